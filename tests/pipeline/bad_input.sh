#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Gives broken input to the command line. It must print a sentence that names the file, exit with an error code and not by a signal, and
# write no partial output.
# usage: bad_input.sh DOPPEL WORKDIR
set -euo pipefail
doppel="$1" work="$2"
rm -rf "$work" && mkdir -p "$work"
cd "$work"
"$doppel" sample -o scan --small --seed 5 2>sample.log
failures=0
# refuses NAME PATTERN COMMAND...: COMMAND must exit with 1 … 127 and print PATTERN.
refuses() {
    local name="$1" pattern="$2" status=0
    shift 2
    "$@" >out.log 2>&1 || status=$?
    if [ $status -eq 0 ] || [ $status -ge 128 ] || ! grep -qE "$pattern" out.log; then
        echo "FAILED: $name (exit $status):" >&2
        tail -n 5 out.log >&2
        failures=$((failures + 1))
    else
        echo "ok: $name: $(grep -E "$pattern" out.log | head -n 1 | cut -c1-160)"
    fi
}
copy() { rm -rf bad && cp -r scan bad; }
image=$(python3 -c "import json; print(json.load(open('scan/scan.json'))['frames'][0]['image'])")
mask=$(python3 -c "import json; print(json.load(open('scan/scan.json'))['frames'][0]['mask'])")

copy; rm "bad/$image"
refuses "missing image" "$(basename "$image" .jpg)" "$doppel" reconstruct bad -o out
copy; truncate -s 900 "bad/$image"
refuses "truncated JPEG" "$(basename "$image" .jpg)" "$doppel" reconstruct bad -o out
python3 - "$(basename "$image" .jpg)" <<'P' || { echo "FAILED: verdict.json of a refused scan" >&2; failures=$((failures + 1)); }
import json, sys
verdict = json.load(open("out/verdict.json"))
assert verdict["refused"]["stage"] == "ingest" and "REFUSE" in verdict["refused"]["reason"], verdict["refused"]
assert [(shot["topic"], shot["frames"]) for shot in verdict["film_again"]] == [("files", [sys.argv[1]])], verdict["film_again"]
assert verdict["scan_check"]["verdict"] == "REFUSE"
P
copy; python3 - <<'P'
import json
scan = json.load(open("bad/scan.json"))
scan["frames"][0]["camera"]["fx"] = 0
json.dump(scan, open("bad/scan.json", "w"))
P
refuses "zero focal length" "scan.json" "$doppel" reconstruct bad -o out
copy; python3 - <<'P'
import json
scan = json.load(open("bad/scan.json"))
del scan["frames"][0]["camera"]
json.dump(scan, open("bad/scan.json", "w"))
P
refuses "absent camera" "scan.json" "$doppel" reconstruct bad -o out
copy; python3 - <<'P'
# An empty file of true positions: without the check it ended the report, after the training.
import json
truth = json.load(open("bad/truth.json"))
frame = next(f for f in truth["frames"] if f.get("posed"))
open("bad/" + frame["posed"], "w").close()
P
for command in check reconstruct; do
    refuses "an empty truth file, before any stage: $command" "bad/posed/.*\.bin: 0 bytes" "$doppel" $command bad -o truth
done
[ ! -d truth/work ] || [ -z "$(ls truth/work | grep -v ingest)" ] || { echo "FAILED: stages ran: $(ls truth/work)" >&2; failures=$((failures + 1)); }
copy; head -c 500 scan/scan.json >bad/scan.json
refuses "truncated scan.json" "scan.json" "$doppel" reconstruct bad -o out
if ! grep -q '"reason": "[^"]*bad/scan.json: not valid JSON' out/verdict.json; then
    echo "FAILED: verdict.json of an unreadable scan" >&2
    failures=$((failures + 1))
fi
refuses "no such scan" "nowhere" "$doppel" reconstruct nowhere -o out
python3 - <<'P'
# One triangle as a glTF binary, with neither skin nor weights.
import json, struct
positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
text = json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(positions)}], "bufferViews": [{"buffer": 0, "byteLength": len(positions)}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}).encode()
text += b" " * (-len(text) % 4)
open("plain.glb", "wb").write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(positions)) + struct.pack("<I4s", len(text), b"JSON") + text
    + struct.pack("<I4s", len(positions), b"BIN\0") + positions)
P
refuses "a body without skin weights" "weights|skin" "$doppel" reconstruct scan -o out --body plain.glb
refuses "unknown command" "unknown command 'rendr' .did you mean 'render'" "$doppel" rendr scan
refuses "NaN as a number" "nan" "$doppel" render none.glb -o a.png --time nan
refuses "a size that is none, before any work" "720by1280" "$doppel" render none.glb -o a.png --size 720by1280
refuses "an output name that cannot be, before any work" "must end in" "$doppel" render none.glb -o a.jpg
refuses "an output folder that is not there, before any work" "no folder" "$doppel" pack none.glb -o nowhere/a.glb
refuses "unknown option" "frobnicate" "$doppel" reconstruct scan -o out --frobnicate
refuses "no such avatar" "none.glb" "$doppel" render none.glb -o out.png
head -c 300 /dev/urandom >noise.glb
refuses "noise as an avatar" "noise.glb" "$doppel" render noise.glb -o out.png
refuses "noise as a garment's avatar" "noise.glb" "$doppel" dress noise.glb --top noise.glb -o out.glb
refuses "nothing to put on" "avatar.*--top|none.glb" "$doppel" dress none.glb -o out.glb
refuses "noise inspected" "noise.glb" "$doppel" inspect noise.glb
truncate -s 1T huge.glb  # more than fits into memory, and more than is read in an hour
for command in inspect bench "render -o out.png" "pack -o out.glb" "dress --hair huge.glb -o out.glb" "export -o out.ply"; do
    # shellcheck disable=SC2086  # the command and its options are words
    refuses "1 TB that are no avatar, by their first bytes: $command" "huge.glb: the file is neither" "$doppel" $command huge.glb
done
rm huge.glb
"$doppel" body import builtin -o body.glb >/dev/null
truncate -s -1 body.glb
refuses "a truncated .glb" "states" "$doppel" inspect body.glb
refuses "JSON to a full disk" "No space left" bash -c '"$0" body show builtin >/dev/full' "$doppel"
refuses "output that cannot be written" "full|Not a directory|cannot" "$doppel" sample -o /dev/full/x --small
[ ! -e out.png ] || { echo "FAILED: a refused render left out.png" >&2; failures=$((failures + 1)); }
[ ! -e out/avatar.glb ] || { echo "FAILED: a refused reconstruction left an avatar" >&2; failures=$((failures + 1)); }
[ $failures -eq 0 ]
