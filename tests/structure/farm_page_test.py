#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/farm/index_page.py: what the page says of avatars, refusals and runs that were continued."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PAGE = pathlib.Path(__file__).resolve().parents[2] / "tools/farm/index_page.py"
ADVICE = "What to film again, the most helpful first:\n  1. Film the <face>\n  2. Walk once more\n"


class Farm:
    """An output folder of a night."""

    def __init__(self, folder):
        self.out = pathlib.Path(folder)

    def refuse(self, name, message):
        self.write(name, {"error": {"message": message}})

    def finish(self, name, minutes, cpu_minutes, reused=False):
        self.write(name, {"avatar": str(self.out / name / "avatar.glb"), "figures": str(self.out / name / "report.json"),
                          "stages": [{"name": "train", "seconds": 60 * minutes, "peakBytes": 1, "reused": reused}],
                          "cpuSeconds": 60 * cpu_minutes, "peakBytes": 3 << 29})
        (self.out / name / "avatar.glb").write_bytes(bytes(2_000_000))
        means = {"static": {"with_pose_fit": {"masked_psnr_db": 25.125}}}
        (self.out / name / "report.json").write_text(json.dumps({"means": means, "word": "Usable", "film_again": ADVICE}))
        (self.out / name / "portrait.jpg").write_bytes(b"JPEG")

    def write(self, name, result):
        (self.out / name).mkdir()
        (self.out / name / "result.json").write_text(json.dumps(result))

    def page(self, *names):
        subprocess.run([sys.executable, PAGE, self.out, *names], check=True)
        assert [path.name for path in self.out.iterdir() if path.name.startswith(".index")] == [], "no part of a page is left"
        return (self.out / "index.html").read_text()


class IndexPage(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.farm = Farm(made.name)

    def test_refusals_come_first_and_cannot_write_markup(self):
        self.farm.finish("ada", 6, 9)
        self.farm.refuse("ben", "scan.json: <b> is no name")
        page = self.farm.page("ada", "ben")
        self.assertIn("1 avatars, 1 without one", page)
        self.assertLess(page.index("<td>ben"), page.index("<td>ada"))
        self.assertIn("&lt;b&gt; is no name", page)
        self.assertNotIn("<b> is", page)

    def test_figures_of_an_avatar(self):
        self.farm.finish("ada", 6, 9)
        cells = '<td class="n">25.12<td class="n">–<td class="n">2.00<td class="n">6.0<td class="n">1536'
        self.assertIn(cells, self.farm.page("ada"))

    def test_a_row_shows_the_person_the_word_and_the_first_advice(self):
        self.farm.finish("ada", 6, 9)
        page = self.farm.page("ada")
        self.assertIn('<img src="ada/portrait.jpg"', page)
        self.assertIn("<b>Usable</b><br>Film the &lt;face&gt;<td", page)
        self.assertNotIn("http-equiv", page, "a finished page stays")

    def test_the_page_grows_during_the_night(self):
        self.farm.finish("ada", 6, 9)
        page = self.farm.page("cleo", "ada")
        self.assertIn("1 avatars, 0 without one, 1 not done yet.", page)
        self.assertLess(page.index("<td>ada"), page.index("<td>cleo"))
        self.assertIn('http-equiv="refresh"', page)
        self.farm.refuse("cleo", "no pictures")
        self.assertNotIn("not done", self.farm.page("cleo", "ada"))

    def test_needs_of_many_are_those_of_runs_that_were_not_continued(self):
        self.farm.finish("ada", 6, 9)
        self.farm.finish("ben", 1, 1, reused=True)
        page = self.farm.page("ada", "ben")
        self.assertIn("6.0 minutes a scan. 10,000 like these need 1,500 core-hours (150 cores", page)
        self.assertIn("1.5 GiB of memory a job and 0.02 TB", page)

    def test_without_an_avatar_nothing_is_planned(self):
        self.farm.refuse("ben", "no pictures")
        self.assertNotIn("10,000", self.farm.page("ben"))


if __name__ == "__main__":
    unittest.main()
