#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Time against the number of splats and against pixels, of one avatar blown up (bench_load) to several sizes, as Markdown.
#
#   tools/bench/scaling.sh BENCH_LOAD DOPPEL AVATAR.glb [SPLATS...]      default: 60000 133000 267000 533695 1000000 2000000
#
# ms a frame, medians of five, renderers in turns; ns a splat behind it. At most linear: ns a splat must not grow down a column.
set -eu
load=${1:?usage: scaling.sh BENCH_LOAD DOPPEL AVATAR.glb [SPLATS...]} doppel=${2:?the doppel program} avatar=${3:?an avatar}
shift 3
[ $# -gt 0 ] || set -- 60000 133000 267000 533695 1000000 2000000
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for splats in "$@"; do
    "$load" "$avatar" "$splats" 1 "$work/big.glb" >/dev/null
    "$doppel" bench "$work/big.glb" --no-reference --repeats 5 --renderers software vulkan-quads vulkan-tiles --json "$work/$splats.jsonl" >/dev/null 2>"$work/log" || { tail -n 5 "$work/log" >&2; exit 1; }
done
python3 - "$work" "$@" <<'P'
import json, sys
work, counts = sys.argv[1], [int(n) for n in sys.argv[2:]]
rows = {n: [json.loads(line) for line in open(f"{work}/{n}.jsonl")] for n in counts}
frames = {n: {(r["case"], r["device"]): r["ms_p50"] for r in rows[n] if "ms_p50" in r} for n in counts}
columns = list(frames[counts[0]])
short = lambda device: "software" if device.startswith("software") else "tiles" if "tiles" in device else "quads"
print("| splats | " + " | ".join(f"{case}, {short(device)}" for case, device in columns) + " |")
print("|---|" + "---|" * len(columns))
for n in counts:
    print(f"| {n:,} | " + " | ".join(f"{frames[n][c]:.1f} ms, {frames[n][c] * 1e6 / n:.0f} ns" if c in frames[n] else "not on this device" for c in columns) + " |")
P
