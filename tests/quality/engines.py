#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trains one scan on the CPU and on a GPU, and compares the masked PSNR of the avatars' held-out pictures.

    engines.py DOPPEL WORKDIR                             150 steps of one seed; exit 77 without a Vulkan device
    engines.py DOPPEL WORKDIR --steps 600 --seeds 3       longer
    engines.py DOPPEL WORKDIR --json FILE                 the figures too

The scan is scan-tiny where it is at hand, else a small sample. An emulated GPU is taken too. Exit status 1: the means differ by more than
0.1 dB, or both engines gave the same avatar, so that one of them did not train.
"""
import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True

from quality import SKIPPED, run, scan_tiny  # noqa: E402  (Python puts this script's folder on the module path)

MOST_DB = 0.1  # between the means; measured 0.002 after 60 steps on lavapipe
# What follows the training is short, because both engines share it.
PRESET = {"startSplats": 20000, "maxSplats": 30000, "shDegree": 0, "polishSteps": 10, "poseFitRounds": 4}


def has_gpu(doppel, work):
    """Whether --engine gpu finds a device: asked by a run that ends before it begins."""
    result = subprocess.run([doppel, "bench", "training", "--engine", "gpu", "--size", "16x16", "--splats", "100", "--json", work / "gpu.jsonl"],
                            capture_output=True, text=True)
    if result.returncode != 0:
        print(f"engines.py: {result.stderr.strip()}")
    return result.returncode == 0


def trained(doppel, scan, work, engine, seed, log):
    """Masked PSNR of held-out pictures by kind, and the avatar's bytes. The engines share a folder, and so the fits."""
    out = work / "out"
    run([doppel, "reconstruct", scan, "-o", out, "--preset", work / "preset.json", "--engine", engine, "--seed", str(seed)], log)
    means = json.loads((out / "report.json").read_text(encoding="utf-8"))["means"]
    return {kind: means[kind]["with_pose_fit"]["masked_psnr_db"] for kind in ("static", "dynamic")}, (out / "avatar.glb").read_bytes()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("doppel", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=150)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    doppel, work = options.doppel.resolve(), options.work.resolve()
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    if not has_gpu(doppel, work):
        print("[  SKIPPED ] quality.engines (0 ms)")
        return SKIPPED
    log, scan = work / "log.txt", scan_tiny()
    if scan is None:
        scan = work / "scan"
        run([doppel, "sample", "-o", scan, "--small", "--seed", "1"], log)
    (work / "preset.json").write_text(json.dumps(PRESET | {"steps": options.steps}), encoding="utf-8")
    found = {engine: [trained(doppel, scan, work, engine, seed, log) for seed in range(1, options.seeds + 1)] for engine in ("cpu", "gpu")}
    failures = 0
    rows = []
    for kind in ("static", "dynamic"):
        cpu, gpu = (statistics.mean(psnr[kind] for psnr, _ in found[engine]) for engine in ("cpu", "gpu"))
        met = abs(cpu - gpu) <= MOST_DB
        failures += not met
        print(f"{'met   ' if met else 'MISSED'} held-out {kind}: CPU {cpu:.3f} dB, GPU {gpu:.3f} dB, at most {MOST_DB} apart")
        rows.append({"kind": kind, "steps": options.steps, "seeds": options.seeds, "cpu_db": cpu, "gpu_db": gpu})
    if any(cpu == gpu for (_, cpu), (_, gpu) in zip(found["cpu"], found["gpu"])):
        print("MISSED the avatars of both engines are the same: one of them did not train")
        failures += 1
    if options.json:
        options.json.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
