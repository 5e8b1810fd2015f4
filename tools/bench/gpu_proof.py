#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The JSON of tools/prove-gpu, from the JSON lines of its benches.

    gpu_proof.py software FILE.jsonl    yes if the device of these frames is a driver on the CPU, otherwise no
    gpu_proof.py report FOLDER ...      one JSON object of device.jsonl, frames.jsonl, ways.jsonl, writes.jsonl, training.*.jsonl and engines.jsonl in FOLDER;
                                        a bench that failed left none
"""
import argparse
import json
import pathlib
import re
import sys

sys.dont_write_bytecode = True

from publishing import benches, machine  # noqa: E402  (Python puts this script's folder on the module path)


def rows_of(path):
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def device_of(rows):
    """The device's name alone, of a renderer's name as "vulkan: NVIDIA H200 (tiles)"."""
    return re.sub(r"^vulkan: (.*) \((quads|tiles)\)$", r"\1", rows[0]["device"])


def frame(row):
    """gpu_ms is the device's clock; ms is the time until the pictures are in memory."""
    kept = {key: row[key] for key in ("case", "renderer", "splats", "splats_drawn", "samples", "resident_bytes")}
    times = {"ms": row["ms_p50"], "gpu_ms": row["gpu_ms_p50"], "draw_ms": row["draw_ms_p50"]}
    return {**kept, **times, "pass_gpu_ms": row.get("pass_gpu_ms", {})}


def report(folder, options):
    frames = [row for row in benches.with_passes(rows_of(folder / "frames.jsonl")) if "renderer" in row]
    device = device_of(rows_of(folder / "device.jsonl"))
    return {
        "device": device,
        "driver": machine.driver(),
        "software": machine.is_software(device),
        "seconds": options.seconds,
        "tests": {"passed": options.passed, "failed": options.failed, "skipped": options.skipped},
        "avatar": pathlib.Path(options.avatar).name,
        "shrink": options.shrink,
        "frames": [frame(row) for row in frames],
        "ways": rows_of(folder / "ways.jsonl"),
        "writes": rows_of(folder / "writes.jsonl"),
        "training": {engine: rows_of(folder / f"training.{engine}.jsonl") for engine in ("gpu", "cpu", "2k")},
        "engines": rows_of(folder / "engines.jsonl"),
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("software").add_argument("file", type=pathlib.Path)
    whole = commands.add_parser("report")
    whole.add_argument("folder", type=pathlib.Path)
    whole.add_argument("--avatar", required=True)
    for count in ("shrink", "passed", "failed", "skipped", "seconds"):
        whole.add_argument(f"--{count}", type=int, required=True)
    options = parser.parse_args(arguments)
    if options.command == "software":
        print("yes" if machine.is_software(device_of(rows_of(options.file))) else "no")
    else:
        print(json.dumps(report(options.folder, options), indent=1))


if __name__ == "__main__":
    main()
