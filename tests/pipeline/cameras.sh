#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Finds the cameras of a scan that has none through the command line, with a program that plays COLMAP. The cameras of still pictures and
# close-ups must come back as the player gave them, whatever its world, and pictures that nothing places must be named.
# usage: cameras.sh DOPPEL WORKDIR
set -euo pipefail
doppel="$1" work="$2"
tests="$(cd "$(dirname "$0")" && pwd)"
rm -rf "$work" && mkdir -p "$work/bin"
cd "$work"
fail() { echo "FAILED: $1" >&2; tail -n 20 out.log >&2; exit 1; }
"$doppel" sample -o scan --small --seed 5 2>sample.log
cp "$tests/fake_colmap.py" bin/colmap
"$tests/../../tools/strip_scan.py" scan blind camera
export FAKE_COLMAP_SCAN="$work/scan" PATH="$work/bin:$PATH"
"$doppel" cameras blind -o out --truth scan >out.log 2>&1 || fail "exit $?"
grep -q "found for 22 of 22 still pictures, 8 of 8 close-ups" out.log || fail "not all still pictures came back"
# kind, frames, missing, median error of the eye in mm: COLMAP's world has another origin and scale, and neither may be left
grep -qE "^static +22 +0 +0\.0[0-9] " out.log || fail "the cameras of still pictures are not those that were given"
grep -qE "^close-up +8 +0 +0\.0[0-9] " out.log || fail "the cameras of close-ups are not those that were given"
grep -q "too few matches with their neighbours; film that part again, slower" out.log || fail "pictures without a place are not named"

# A close-up that COLMAP puts far away is none that it placed: the person places it, or it is left out, and nothing is worse than before.
FAKE_COLMAP_FAR=close_003 "$doppel" cameras blind -o far --truth scan >out.log 2>&1 || fail "exit $?"
grep -qE "found for 22 of 22 still pictures, [78] of 8 close-ups" out.log || fail "a close-up far away takes others with it"
# kind, frames, missing, eye mm: median, 90 %, worst
grep -qE "^close-up +8 +[01] +[0-9]\.[0-9]+ +[0-9.]+ +[0-9]{1,2}\.[0-9]+ " out.log || fail "a close-up stands far from its place"

# Too few pictures are placed: the scan is refused, and OUT/verdict.json tells programs what people are told.
FAKE_COLMAP_PLACES=7 "$doppel" reconstruct blind -o refused >out.log 2>&1 && fail "a scan of 7 placed pictures was not refused"
python3 - <<'P' || fail "verdict.json does not say what to film again"
import json
verdict = json.load(open("refused/verdict.json"))
assert verdict["refused"]["stage"] == "cameras", verdict["refused"]
assert "cameras of too few pictures" in verdict["refused"]["reason"], verdict["refused"]
assert verdict["film_again"], "nothing to film again"
named = {name for shot in verdict["film_again"] for name in shot["frames"]}
placed = {frame["name"] for frame in json.load(open("refused/stages/cameras/cameras.json"))["frames"]}
asked = {frame["name"] for frame in json.load(open("blind/scan.json"))["frames"]}
assert named == asked - placed, (named ^ (asked - placed))
assert all(shot["part"] and "film" in shot["sentence"] for shot in verdict["film_again"]), verdict["film_again"]
P
echo "cameras.sh: 22 still and 8 close cameras came back"
