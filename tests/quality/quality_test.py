#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the gate of quality.py on made-up figures, and the arithmetic of bars.json."""
import contextlib
import io
import json
import math
import unittest

import quality

VALUES = {"dB": [20.0, 20.1, 20.2, 20.1, 20.1], "mm": [15.0] * 5, "bytes": [1000.0, 1000.0, 1000.0, 1000.0, 1100.0]}
BARS = {unit: quality.entry_of(values, unit) for unit, values in VALUES.items()}


def misses(**figures):
    with contextlib.redirect_stdout(io.StringIO()):
        return quality.misses({unit: (value, unit) for unit, value in figures.items()}, BARS)


class Gate(unittest.TestCase):
    def test_bar_is_the_mean_less_the_larger_margin(self):
        self.assertEqual(BARS["dB"]["bar"], 19.6)  # 0.5 dB is more than 2σ = 0.14 dB
        self.assertEqual(BARS["mm"]["bar"], 16.0)  # lower is better
        self.assertAlmostEqual(BARS["bytes"]["bar"], 1020 + 2 * 44.72, delta=1)  # 2σ is more than 2 %

    def test_figures_at_the_bar_are_met_and_worse_ones_are_missed(self):
        self.assertEqual(misses(dB=19.6, mm=16, bytes=1000), 0)
        self.assertEqual(misses(dB=19.59, mm=16, bytes=1000), 1)
        self.assertEqual(misses(dB=25, mm=16.01, bytes=2000), 2)
        self.assertEqual(misses(dB=math.nan, mm=math.nan, bytes=math.nan), 3)

    def test_a_missing_figure_or_a_bar_by_hand_is_refused(self):
        with self.assertRaises(SystemExit):
            misses(dB=25, mm=10)
        by_hand = {"dB": {**BARS["dB"], "bar": 10.0}}
        with self.assertRaises(SystemExit):
            quality.misses({"dB": (15.0, "dB")}, by_hand)

    def test_bars_json_follows_from_its_values(self):
        bars = json.loads(quality.BARS.read_text(encoding="utf-8"))
        self.assertEqual(set(bars), {"procedural", "scan-tiny"})
        for entries in bars.values():
            for name, entry in entries.items():
                self.assertEqual(len(entry["values"]), 5, name)
                self.assertEqual(entry, quality.entry_of(entry["values"], entry["unit"]), name)


if __name__ == "__main__":
    unittest.main()
