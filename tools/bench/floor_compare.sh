#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Times the software renderer and the research prototype ("floor") on the same PLY in alternating rounds. Prints the ratio of medians.
#
#   tools/bench/floor_compare.sh BENCH_SPLAT [PROTO_DIR [ROUNDS [--json FILE]]]
#
# BENCH_SPLAT: the built bench_splat. PROTO_DIR: folder with floor.cpp and scene.cpp (default ../shared/research/proto-splat beside
# this checkout). Its programs and a PLY of 132 MB are made in ${DOPPEL_FLOOR_DIR:-/tmp/doppel-floor} and kept for the next run.
# Exit code 1 when the ratio is above DOPPEL_FLOOR_BAR (default 1.5).
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bench=${1:?usage: floor_compare.sh BENCH_SPLAT [PROTO_DIR [ROUNDS]]}
proto=${2:-$here/../../../shared/research/proto-splat}
rounds=${3:-5}
json=${5:-}  # argument 4 is --json
work=${DOPPEL_FLOOR_DIR:-/tmp/doppel-floor}
[ -f "$proto/floor.cpp" ] || { echo "floor_compare: no floor.cpp in $proto; give its folder as second argument" >&2; exit 2; }
mkdir -p "$work"

# Build the floor for 16 lanes if the machine has AVX-512, else for 8.
lanes=8
grep -q avx512dq /proc/cpuinfo && lanes=16
[ -x "$work/floor$lanes" ] || g++ -O3 -march=native -pthread -DVW=$lanes "$proto/floor.cpp" -o "$work/floor$lanes"
[ -x "$work/scene" ] || g++ -O2 "$proto/scene.cpp" -o "$work/scene"
[ -f "$work/a533.ply" ] || { "$work/scene" 533695 "$work/a533.tmp" 0.0015 0.003 >/dev/null && mv "$work/a533.tmp" "$work/a533.ply"; }

threads=$(nproc)
: >"$work/floor.txt"
: >"$work/ours.txt"
round=0
while [ "$round" -lt "$rounds" ]; do
    "$work/floor$lanes" "$work/a533.ply" 2048 945 0.9 4.85 "$threads" 15 >>"$work/floor.txt"
    "$bench" "$work/a533.ply" 2048 945 0.9 4.85 "$threads" 15 >>"$work/ours.txt"
    round=$((round + 1))
done

field() { sed -n "s/.* $2 \([0-9.]*\).*/\1/p" "$1" | sort -n | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'; }
echo "533,695 splats, SH 3, 2048x945, $threads threads, $rounds alternating rounds of 15 frames; medians in ms ($(date -u +%F), $(sed -n 's/model name[^:]*: //p' /proc/cpuinfo | head -1), load $(cut -d' ' -f1 /proc/loadavg))"
echo "step         floor    doppel"
for step in project+SH sort bin raster total-median; do
    printf '%-12s %7s  %7s\n' "$step" "$(field "$work/floor.txt" "$step")" "$(field "$work/ours.txt" "$step")"
done
if [ -n "$json" ]; then
    for step in project+SH sort bin raster total-median; do
        awk -v step="$step" -v rounds="$rounds" -v a="$(field "$work/ours.txt" "$step")" -v b="$(field "$work/floor.txt" "$step")" 'BEGIN {
            printf "{\"device\":\"software\",\"step\":\"%s\",\"rounds\":%d,\"floor_ms\":%s,\"doppel_ms\":%s,\"ratio\":%.4f}\n", step, rounds, b, a, a / b}'
    done >"$json"
fi
awk -v a="$(field "$work/ours.txt" total-median)" -v b="$(field "$work/floor.txt" total-median)" -v bar="${DOPPEL_FLOOR_BAR:-1.5}" \
    'BEGIN {printf "ratio %.2f (bar %.2f)\n", a / b, bar; exit a / b > bar}'
