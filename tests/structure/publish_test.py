#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of tools/bench/publish: tables, bars, raw files, and a run that is cut off."""
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/bench"))

import gpu_proof  # noqa: E402
from publishing import benches, command, machine, markdown, pages, raw  # noqa: E402


class GpuProof(unittest.TestCase):
    def test_the_object_holds_device_tests_and_ms_a_frame_by_case(self):
        frame = {"case": "phone", "renderer": "vulkan-tiles", "device": "vulkan: NVIDIA H200 (tiles)", "splats": 9, "splats_drawn": 7,
                 "samples": 1, "resident_bytes": 5, "ms_p50": 2.5, "gpu_ms_p50": 0.8, "draw_ms_p50": 0.1, "views": 1}
        line = {"case": "phone", "device": frame["device"], "views": 1, "pass": "tiles.fill", "gpu_ms_p50": 0.3, "gpu_ms_p95": 0.4}
        with tempfile.TemporaryDirectory() as folder:
            for name, rows in (("device", [frame]), ("frames", [frame, line]), ("ways", [{"way": "read back"}]),
                               ("writes", [{"layout": "SH"}])):
                (pathlib.Path(folder) / f"{name}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
            said = self.say("report", folder, "--avatar", "demo/a.glb", "--shrink", 1, "--passed", 12, "--failed", 1, "--skipped", 2,
                            "--seconds", 90)
            self.assertEqual(self.say("software", f"{folder}/device.jsonl"), "no\n")
        got = json.loads(said)
        self.assertEqual((got["device"], got["software"], got["avatar"]), ("NVIDIA H200", False, "a.glb"))
        self.assertEqual(got["tests"], {"passed": 12, "failed": 1, "skipped": 2})
        self.assertEqual([(f["case"], f["ms"], f["gpu_ms"], f["pass_gpu_ms"]) for f in got["frames"]],
                         [("phone", 2.5, 0.8, {"tiles.fill": 0.3})])
        self.assertEqual(got["ways"], [{"way": "read back"}])
        self.assertEqual(got["writes"], [{"layout": "SH"}])

    def test_a_driver_on_the_cpu_is_told(self):
        self.assertTrue(machine.is_software("llvmpipe (LLVM 15.0.6, 256 bits)"))

    def say(self, *arguments):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            gpu_proof.main([str(a) for a in arguments])
        return out.getvalue()


class Tables(unittest.TestCase):
    def test_a_row_with_a_cell_too_many_is_refused(self):
        with self.assertRaisesRegex(ValueError, "3 cells under 2 headings"):
            markdown.table(["a", "b"], [["1", "2"], ["1", "2", "3"]])

    def test_a_bar_is_marked_as_met_or_missed(self):
        row = {"ms": 30, "db": 22.5, "bars": {"ms": benches.at_most(40), "db": benches.at_least(23)}}
        self.assertEqual(markdown.barred(row, "ms", 1, "ms"), "30.0 ms (met: ≤ 40)")
        self.assertEqual(markdown.barred(row, "db", 2, "dB"), "22.50 dB (**missed**: ≥ 23)")
        self.assertEqual(markdown.barred(row, "nothing"), markdown.NOTHING)
        row = {"load": 976.4, "share": 0.071, "bars": {"load": benches.at_most(500), "share": benches.at_most(0.14)}}
        self.assertEqual(markdown.barred(row, "load", 0, "ms"), "976 ms (**missed**: ≤ 500)")
        self.assertEqual(markdown.barred(row, "share", 1, "%", 100), "7.1 % (met: ≤ 14)")
        self.assertIs(raw.met({"ms": 40, "bars": {"ms": benches.at_most(40)}}, "ms"), True)

    def test_a_page_is_written_when_nothing_was_taken(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs/benchmarks").mkdir(parents=True)
            written = pages.write_all(root, root / "docs")
            self.assertIn("Not taken yet: `tools/bench/publish --only floor`", (root / "docs/benchmarks/floor.md").read_text())
            self.assertEqual(len(written), len(pages.PAGES) + 1)


class Reports(unittest.TestCase):
    def test_figures_keep_the_bars_that_the_report_states(self):
        def stated(key, value, **bar):
            return {"key": key, "value": value, "unit": "", **({"bar": {**bar, "met": True}} if bar else {})}
        fit = "truth.body_fit."
        score = {key: 1.0 for key in ("masked_psnr_db", "masked_ssim", "alpha_iou", "full_psnr_db", "full_ssim")}
        report = {
            "means": {"static": {key: score for key in ("with_pose_fit", "without_pose_fit", "floor_flat_labels", "floor_vertex_colours")}},
            "above_floors": [stated("above_floor.static", 5.0, at_least=4.0)],
            "figures": [stated(fit + "keypoints_mean", 16.0, at_most=15.0), stated(fit + "keypoints_p95", 39.0, at_most=40.0),
                        stated(fit + "limbs_median", 2.0), stated(fit + "limbs_p95", 9.0)],
            "facts": {"splats": "1", "body": "b", "training": "t", "scan": "s"}, "stages": [], "evidence": [], "frames": []}
        rows = benches.quality_rows(report, {"static": {"iou": benches.at_least(0.9)}})
        held_out, registration = pages.find(rows, row="held out"), pages.find(rows, row="registration")
        self.assertEqual(held_out["bars"], {"iou": benches.at_least(0.9), "above_floors_db": benches.at_least(4.0)})
        self.assertEqual(registration["bars"], {"keypoints_mean_mm": benches.at_most(15.0), "keypoints_p95_mm": benches.at_most(40.0)})
        self.assertIs(raw.met(registration, "keypoints_mean_mm"), False)
        report["figures"] = []
        self.assertIsNone(pages.find(benches.quality_rows(report, {}), row="registration"), "a scan without truth has no registration")


    def test_seeds_give_a_mean_a_spread_and_a_bar(self):
        def report(db, ratio):
            score = {"masked_psnr_db": db, "union_psnr_db": db - 1, "uncovered": 0.02, "drawn_outside": 0.01}
            return {"means": {kind: {"with_pose_fit": score, "without_pose_fit": score} for kind in ("static", "dynamic")},
                    "figures": [{"key": "garment.bottom.point_distance_ratio", "value": ratio}]}
        rows = benches.seed_rows([report(17, 0.8), report(18, 0.9), report(19, 1.0)],
                                 {"moving": benches.at_least(18.5), "bottom": benches.at_most(0.9)})
        moving = pages.find(rows, figure="moving, with pose fit, dB")
        self.assertEqual((moving["values"], moving["mean"], moving["sigma"]), ([17, 18, 19], 18, 1))
        self.assertEqual(markdown.barred(moving, "mean"), "18.00 (**missed**: ≥ 18.5)")
        bottom = next(r for r in rows if "bottom" in r["figure"])
        self.assertEqual(markdown.barred(bottom, "mean"), "0.90 (met: ≤ 0.9)")
        self.assertFalse([r for r in rows if "top" in r["figure"]], "a scan without a top has no row of it")


class Programs(unittest.TestCase):
    def test_every_program_is_looked_for_where_it_is_built(self):
        for program in sorted({p for bench in benches.BENCHES for p in bench.programs}):
            text = (ROOT / benches.program_folder(program) / "CMakeLists.txt").read_text()
            library = program.removeprefix("lib").removesuffix(".so")
            built = any(f"{make}{name} " in text
                        for make, name in (("add_executable(", program), ("OUTPUT_NAME ", program), ("add_library(", library),
                                           ("doppel_test(", program)))
            self.assertTrue(built, f"{benches.program_folder(program)} does not build {program}")


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.taken = []

    def bench(self, name, fails=lambda: None):
        def take(place):
            self.taken.append(name)
            fails()
            return [{"device": "test", "ms": 1.5, "bars": {"ms": benches.at_most(2)}}]
        return benches.Bench(name, "quick", 1, name, name, (), take)

    def run_all(self, wanted):
        options = command.parse(["--work", str(self.root / "work"), "--build", str(self.root)])
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as errors:
            failed = command.run_benches(options, self.root, wanted)
        return failed, errors.getvalue()

    def test_raw_figures_say_on_what_they_were_taken(self):
        self.assertEqual(self.run_all([self.bench("one")])[0], [])
        file = raw.Store(self.root / "docs/benchmarks").get("one")
        self.assertEqual(file["rows"][0]["ms"], 1.5)
        for field in ("date", "commit", "compiler", "processor", "driver", "loaded", "other_work_cores"):
            self.assertIn(field, file["run"])

    def test_a_run_that_is_cut_off_continues_where_it_stopped(self):
        def interrupted():
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.run_all([self.bench("one"), self.bench("two", interrupted)])
        self.run_all([self.bench("one"), self.bench("two")])
        self.assertEqual(self.taken, ["one", "two", "two"])
        self.run_all([self.bench("one"), self.bench("two")])
        self.assertEqual(self.taken, ["one", "two", "two", "one", "two"], "a finished run is not continued")

    def test_a_bench_that_fails_leaves_the_old_figures_and_the_others_run(self):
        def broken():
            raise benches.BenchError("no device")
        self.run_all([self.bench("one"), self.bench("two")])
        before = (self.root / "docs/benchmarks/one.json").read_text()
        failed, errors = self.run_all([self.bench("one", broken), self.bench("two")])
        self.assertEqual(failed, ["one"])
        self.assertIn("no device", errors)
        self.assertEqual((self.root / "docs/benchmarks/one.json").read_text(), before)
        self.assertEqual(self.taken[-2:], ["one", "two"])

    def test_a_bench_that_was_left_out_is_tried_again_when_the_run_continues(self):
        def lacking():
            raise benches.Skipped("needs a GPU")

        def interrupted():
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.run_all([self.bench("one", lacking), self.bench("two", interrupted)])
        self.assertEqual(self.run_all([self.bench("one"), self.bench("two")])[0], [])
        self.assertEqual(self.taken, ["one", "two", "one", "two"])

    def test_other_work_makes_a_run_loaded(self):
        with mock.patch.object(machine, "busy_seconds", side_effect=[0.0, 1000.0]):
            other = machine.OtherWork()
            self.assertTrue(other.stop()["loaded"])
        with mock.patch.object(machine, "busy_seconds", side_effect=[5.0, 5.0]):
            other = machine.OtherWork()
            self.assertFalse(other.stop()["loaded"])


if __name__ == "__main__":
    unittest.main()
