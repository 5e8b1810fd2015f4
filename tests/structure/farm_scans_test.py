#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/farm/scans.py: which folders a farm takes, and that any change of a scan shows."""
import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/farm"))
import scans  # noqa: E402


class Scans(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.root = pathlib.Path(made.name).resolve()

    def write(self, name, second):
        """A file, and its folders, last changed at a second."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("x")
        while path != self.root:
            os.utime(path, (second, second))
            path = path.parent

    def test_every_visible_folder_is_a_scan_and_files_are_named(self):
        for name in ("ben/walk.mp4", "ada/scan.json", "poly/keyframes/cameras/1.json", "out/ada/avatar.glb", ".git/config", "notes.txt"):
            self.write(name, 10)
        self.assertEqual(scans.scans_below(self.root, self.root / "out"), (["ada", "ben", "poly"], ["notes.txt"]))

    def test_a_picture_that_changed_stands_for_its_scan(self):
        for name, second in (("ada/scan.json", 10), ("ada/images/1.jpg", 20), ("ada/images/2.jpg", 15)):
            self.write(name, second)
        os.utime(self.root / "ada/images/1.jpg", (30, 30))
        self.assertEqual(scans.changed_last(self.root / "ada"), str(self.root / "ada/images/1.jpg"))

    def test_a_removed_picture_changes_its_folder(self):
        self.write("ada/images/1.jpg", 20)
        (self.root / "ada/images/1.jpg").unlink()
        self.assertEqual(scans.changed_last(self.root / "ada"), str(self.root / "ada/images"))

    def test_a_link_to_nowhere_is_passed_over(self):
        self.write("ada/scan.json", 10)
        (self.root / "ada/mask.png").symlink_to("none")
        self.assertIn(scans.changed_last(self.root / "ada"), (str(self.root / "ada"), str(self.root / "ada/scan.json")))


if __name__ == "__main__":
    unittest.main()
