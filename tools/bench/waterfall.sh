#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures the error that the body fit adds on a `doppel sample` scan: reconstructs it once with the fit and once with the true body and poses.
#   tools/bench/waterfall.sh DOPPEL BENCH_TRUE_BODY SCAN OUT [--preset P] [--steps N] [--seed N] [--threads N]
# BENCH_TRUE_BODY: build/release/tools/bench/bench_true_body
set -euo pipefail
[ $# -ge 4 ] || { sed -n '3,5p' "$0" | cut -c3-; exit 2; }
doppel="$1" true_body="$2" scan="$3" out="$4"
shift 4
"$doppel" reconstruct "$scan" -o "$out/ours" "$@"
"$true_body" "$scan" "$out/true-body" "$@"
python3 - "$out" <<'P'
import json, sys
reports = {name: json.load(open(f"{sys.argv[1]}/{name}/report.json")) for name in ("ours", "true-body")}
print("| held-out, masked PSNR dB | whole chain | pose fit off | body fit swapped for the truth | its pose fit off | the body fit costs |")
print("|---|---|---|---|---|---|")
for kind in ("static", "dynamic"):
    row = []
    for report in reports.values():
        means = report["means"].get(kind)
        row += [means[which]["masked_psnr_db"] for which in ("with_pose_fit", "without_pose_fit")] if means else [float("nan")] * 2
    print(f"| {kind} | " + " | ".join(f"{x:.2f}" for x in row) + f" | {row[2] - row[0]:.2f} |")
P
