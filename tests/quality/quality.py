#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reconstructs a small scan and compares its figures with the bars of bars.json: masked PSNR, alpha IoU, keypoints, bytes. Prints the CPU time,
which depends on the machine and on what else it does; docs/benchmarks/training.md judges that.

    quality.py DOPPEL WORKDIR procedural|scan-tiny              the gate: seed 1; exit 77 if the scan is absent
    quality.py DOPPEL WORKDIR procedural|scan-tiny --measure    seeds 1 to 5; rewrites the bars of this scan (README.md)
"""
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
BARS = HERE / "bars.json"
OPTIONS = ["--preset", "draft", "--steps", "600"]
SEEDS = range(1, 6)
MARGINS = {"dB": 0.5, "IoU": 0.005, "mm": 1.0}
BYTES_MARGIN = 0.02  # of the mean
LOWER_IS_BETTER = ("mm", "bytes")
SKIPPED = 77


def scan_tiny():
    """The folder of scan-tiny, found as in tests/unit/shared_data.h, or None."""
    stated = os.environ.get("DOPPEL_SHARED_DATA")
    roots = [pathlib.Path(stated)] if stated else [at / "shared" / "data" for at in HERE.parents]
    return next((root / "scan-tiny" for root in roots if (root / "scan-tiny" / "scan.json").exists()), None)


def run(command, log):
    with open(log, "ab") as out:
        if subprocess.run(command, stdout=out, stderr=out).returncode:
            print(pathlib.Path(log).read_text(errors="replace")[-2000:])
            sys.exit(f"FAILED: {' '.join(map(str, command))}")


def figures(report, avatar_bytes):
    """The gated figures of a report: name -> (value, unit)."""
    found = {}
    for kind in ("static", "dynamic"):
        mean = report["means"][kind]["with_pose_fit"]
        found[f"masked PSNR, held-out {kind}"] = (mean["masked_psnr_db"], "dB")
        found[f"alpha IoU, held-out {kind}"] = (mean["alpha_iou"], "IoU")
    for stage, when in (("body_fit", "after the body fit"), ("pose_fit", "after training and pose fit")):
        means = [f["value"] for f in report["figures"] if f["key"] == f"truth.{stage}.keypoints_mean"]
        if len(means) != 1:
            sys.exit(f"FAILED: the report does not compare keypoints with the scan's truth {when}")
        found[f"keypoints, held-out dynamic, {when}"] = (means[0], "mm")
    found["avatar.glb"] = (float(avatar_bytes), "bytes")
    return found


def bar_of(values, unit):
    mean = statistics.mean(values)
    margin = max(BYTES_MARGIN * mean if unit == "bytes" else MARGINS[unit], 2 * statistics.stdev(values))
    return mean + margin if unit in LOWER_IS_BETTER else mean - margin


def entry_of(values, unit):
    digits = {"dB": 3, "IoU": 4, "mm": 2, "bytes": 0}[unit]
    values = [round(value, digits) for value in values]
    return {"unit": unit, "values": values, "mean": round(statistics.mean(values), digits), "sigma": round(statistics.stdev(values), digits),
            "bar": round(bar_of(values, unit), digits)}


def misses(found, bars):
    """Prints every figure beside its bar and returns the number of missed bars. NaN misses."""
    if found.keys() != bars.keys():
        sys.exit(f"FAILED: figures and bars differ: {sorted(found.keys() ^ bars.keys())}")
    missed = 0
    for name, (value, unit) in found.items():
        entry = bars[name]
        if entry != entry_of(entry["values"], unit):
            sys.exit(f"FAILED: the bar of '{name}' does not follow from its five values (README.md)")
        lower = unit in LOWER_IS_BETTER
        met = value <= entry["bar"] if lower else value >= entry["bar"]
        missed += not met
        print(f"{'met   ' if met else 'MISSED'} {name}: {value:.4f} {unit}, bar {'≤' if lower else '≥'} {entry['bar']} "
              f"(five seeds: {entry['mean']} ± {entry['sigma']})")
    return missed


def reconstruct(doppel, scan, work, seed, log):
    """The figures of one training seed, and the CPU seconds. Seeds share the folder, and so the fits."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run([doppel, "reconstruct", scan, "-o", work / "out", *OPTIONS, "--seed", str(seed)], log)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = json.loads((work / "out" / "report.json").read_text(encoding="utf-8"))
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return figures(report, (work / "out" / "avatar.glb").stat().st_size), cpu_s


def main():
    doppel, work, name = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3]
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    log = work / "log.txt"
    scan = work / "scan" if name == "procedural" else scan_tiny()
    if scan is None:
        # In the form of a skipped GoogleTest case, so that tools/test repeats the reason.
        print(f"quality.py: Skipped\nscan-tiny is not on this machine (no ../shared/data)\n[  SKIPPED ] quality.{name} (0 ms)")
        return SKIPPED
    if name == "procedural":
        run([doppel, "sample", "-o", scan, "--small", "--seed", "1"], log)
    bars = json.loads(BARS.read_text(encoding="utf-8")) if BARS.exists() else {}
    if "--measure" not in sys.argv:
        found, cpu_s = reconstruct(doppel, scan, work, SEEDS[0], log)
        missed = misses(found, bars[name])
        print(f"{cpu_s:.0f} s of CPU")
        return 1 if missed else 0
    measured = []
    for seed in SEEDS:
        found, cpu_s = reconstruct(doppel, scan, work, seed, log)
        measured.append(found)
        print(f"seed {seed}, {cpu_s:.0f} s of CPU:", {key: round(value, 4) for key, (value, _) in found.items()}, flush=True)
    bars[name] = {key: entry_of([found[key][0] for found in measured], unit) for key, (_, unit) in measured[0].items()}
    text = json.dumps(bars, indent=1, sort_keys=True)
    BARS.write_text(text + "\n", encoding="utf-8")
    print(f"wrote the bars of {name} to {BARS}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
