#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/ablations: scans without a kind of frame, signs beyond chance, the table."""
import importlib.machinery
import importlib.util
import json
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools/ablations"
loader = importlib.machinery.SourceFileLoader("ablations", str(TOOL))
ablations = importlib.util.module_from_spec(importlib.util.spec_from_loader("ablations", loader))
loader.exec_module(ablations)


def figures(static, dynamic, size):
    return {"all": (static + 2 * dynamic) / 3, "static": static, "dynamic": dynamic, "dynamic_unfitted": dynamic - 1, "closeup": None, "fine": None, "bytes": size}


class Scans(unittest.TestCase):
    FRAMES = [{"name": name, "kind": kind, "split": split} for name, kind, split in
              [("a", "static_full", "train"), ("b", "dynamic", "train"), ("c", "dynamic", "test"), ("d", "dynamic", "train")]]

    def test_training_frames_of_the_kind_go_and_test_frames_stay(self):
        with tempfile.TemporaryDirectory() as folder:
            scan, out = pathlib.Path(folder) / "scan", pathlib.Path(folder) / "out"
            (scan / "images").mkdir(parents=True)
            (scan / "images/a.jpg").write_text("picture")
            (scan / "scan.json").write_text(json.dumps({"format": "avatar-scan", "frames": self.FRAMES}))
            for _ in range(2):  # a second call must not fail on the links of the first
                made = ablations.scan_without(scan, "dynamic", out)
            text = json.loads((made / "scan.json").read_text())
            self.assertEqual([f["name"] for f in text["frames"]], ["a", "c"])
            self.assertEqual(text["format"], "avatar-scan")
            self.assertEqual((made / "images/a.jpg").read_text(), "picture")
            self.assertEqual(json.loads((scan / "scan.json").read_text())["frames"], self.FRAMES)

    def test_a_scan_without_such_frames_makes_no_row(self):
        with tempfile.TemporaryDirectory() as folder:
            scan = pathlib.Path(folder)
            (scan / "scan.json").write_text(json.dumps({"frames": self.FRAMES}))
            self.assertIsNone(ablations.scan_without(scan, "static_closeup", scan / "out"))


class Signs(unittest.TestCase):
    def test_an_effect_counts_beyond_two_sigma_of_a_difference(self):
        runs = [figures(24, 20.0, 1), figures(24, 20.2, 1), figures(24, 20.4, 1)]
        sigma = ablations.spread(runs, "dynamic")
        self.assertAlmostEqual(sigma, 0.2 * 2 ** 0.5)
        self.assertTrue(ablations.verdict("b", -0.5, sigma).startswith("within chance"))
        self.assertTrue(ablations.verdict("b", -0.6, sigma).startswith("as in the paper"))
        self.assertTrue(ablations.verdict("b", 0.6, sigma).startswith("not as in the paper"))
        self.assertIsNone(ablations.spread(runs, "fine"))

    def test_the_table_shows_differences_to_the_full_method(self):
        rows = {"full": {"figures": figures(24, 21, 1000000)}, "e": {"figures": figures(24.25, 20, 900000)}}
        sigmas = {"all": 0.1, "static": 0.1, "dynamic": 0.1, "dynamic_unfitted": 0.1, "closeup": None, "fine": None, "bytes": 10}
        text = ablations.table({"rows": rows, "sigma_of_a_difference": sigmas})
        full, light = text.splitlines()[2:]
        self.assertIn("24.00 (2σ of a difference 0.20)", full)
        self.assertIn("| -0.58 | +0.25 | -1.00 | -1.00 | – | – | -100,000 | as in the paper (-0.66) |", light)
        self.assertEqual({line.count("|") for line in text.splitlines()}, {11})


if __name__ == "__main__":
    unittest.main()
