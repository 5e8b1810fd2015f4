#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What an avatar may depend on, shown on a small procedural scan:
#   same bytes on 1, 2 and 3 threads; after kill -9 and a rerun; with every truth file moved away; with every held-out image, mask and label replaced by noise.
#   different bytes when a training image changes (so that the comparison can fail).
# usage: independence.sh DOPPEL WORKDIR
set -euo pipefail
doppel="$1" work="$2"
rm -rf "$work" && mkdir -p "$work"
cd "$work"
"$doppel" sample -o scan --small --seed 5 2>sample.log
# Half of the standing frames and ten of the moving ones: a third of the time, and every stage still has its work.
python3 - <<'P'
import json, pathlib
path = pathlib.Path("scan/scan.json")
scan = json.loads(path.read_text())
seen = {}
def keeps(frame):
    count = seen[frame["kind"]] = seen.get(frame["kind"], 0) + 1
    return count <= 10 if frame["kind"] == "dynamic" else count % 2 == 1 or frame["split"] == "test"
scan["frames"] = [f for f in scan["frames"] if keeps(f)]
assert {("static_full", "test"), ("static_closeup", "train"), ("dynamic", "train"), ("dynamic", "test")} <= {(f["kind"], f["split"]) for f in scan["frames"]}
path.write_text(json.dumps(scan))
P
options=(--preset draft --steps 120 --seed 3)
# reconstruct SCAN OUT [options]: until the avatar is written, which happens whole or not at all; held-out poses and the report are not compared here.
reconstruct() {
    "$doppel" reconstruct "$1" -o "$2" "${options[@]}" "${@:3}" >"$2.log" 2>&1 &
    local pid=$!
    while kill -0 $pid 2>/dev/null && [ ! -f "$2/avatar.glb" ]; do sleep 0.2; done
    kill -TERM $pid 2>/dev/null || true
    wait $pid 2>/dev/null || true
    [ -f "$2/avatar.glb" ] || { tail -n 20 "$2.log" >&2; echo "reconstruct $2 failed" >&2; exit 1; }
}
same() { cmp -s "$1/avatar.glb" "$2/avatar.glb" && echo "ok: $3" || { echo "FAILED: $3: $1/avatar.glb and $2/avatar.glb differ" >&2; exit 1; }; }

reconstruct scan one --threads 1
"$doppel" reconstruct scan -o one "${options[@]}" >>one.log 2>&1 || { tail -n 20 one.log >&2; echo "the rest of reconstruct one failed" >&2; exit 1; }  # poses and report too, on more threads
[ -f one/report.html ] || { echo "FAILED: no report" >&2; exit 1; }
reconstruct scan three --threads 3
same one three "1 and 3 threads give the same bytes"

# Truth: everything FORMAT.md calls truth is gone, and `xy` with it.
cp -r scan hidden
rm -rf hidden/truth.json hidden/geometry hidden/posed hidden/hires
python3 - <<'P'
import json, pathlib
for path in pathlib.Path("hidden/keypoints").glob("*.json"):
    data = json.loads(path.read_text())
    data.pop("xy", None)
    path.write_text(json.dumps(data))
scan = json.loads(pathlib.Path("hidden/scan.json").read_text())
scan.pop("truth", None)
scan.pop("geometry", None)
if "skeleton" in scan:
    scan["skeleton"].pop("rest_positions", None)
pathlib.Path("hidden/scan.json").write_text(json.dumps(scan))
P
reconstruct hidden blind
same one blind "without any truth file the bytes are the same"

# Held-out pictures become noise of the same size; the files stay readable.
cp -r scan noisy
python3 - <<'P'
import json, pathlib, random, struct, zlib
random.seed(1)
def png(path, width, height, value):
    rows = b"".join(b"\0" + bytes(value() for _ in range(width)) for _ in range(height))
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
scan = json.loads(pathlib.Path("noisy/scan.json").read_text())
width, height = scan["image_size"]
others = [f for f in scan["frames"] if f["split"] == "train"]
for frame in scan["frames"]:
    if frame["split"] != "test":
        continue
    other = random.choice(others)
    pathlib.Path("noisy", frame["image"]).write_bytes(pathlib.Path("scan", other["image"]).read_bytes())  # another picture: as wrong as noise, and a JPEG
    png(pathlib.Path("noisy", frame["mask"]), width, height, lambda: random.choice((0, 255)))
    png(pathlib.Path("noisy", frame["labels"]), width, height, lambda: random.randrange(6))
P
reconstruct noisy deceived
same one deceived "held-out pictures cannot reach the avatar"

# Stopped in training (a checkpoint is written), killed outright, continued.
interrupt() {  # interrupt SIGNAL: starts the run, waits until it trains, sends the signal
    "$doppel" reconstruct scan -o killed "${options[@]}" >>killed.log 2>&1 &
    local pid=$!
    for _ in $(seq 600); do
        [ -d killed/stages/*co-optimise.work ] 2>/dev/null && break
        kill -0 $pid 2>/dev/null || break
        sleep 0.1
    done
    sleep 1  # training takes some three seconds
    kill "$1" $pid 2>/dev/null || echo "note: the run had finished before $1"
    wait $pid 2>/dev/null || true
}
interrupt -TERM
ls killed/stages/*co-optimise.work/checkpoint >/dev/null 2>&1 && echo "stopped in training, checkpoint kept"
interrupt -KILL
reconstruct scan killed
same one killed "a stopped and killed run continues to the same bytes"

# The comparison itself can fail: a changed training picture changes the avatar.
cp -r scan changed
first=$(python3 -c "import json; print([f['image'] for f in json.load(open('scan/scan.json'))['frames'] if f['split'] == 'train'][0])")
second=$(python3 -c "import json; print([f['image'] for f in json.load(open('scan/scan.json'))['frames'] if f['split'] == 'train'][5])")
cp "scan/$second" "changed/$first"
reconstruct changed other
cmp -s one/avatar.glb other/avatar.glb && { echo "FAILED: a changed training picture changed nothing" >&2; exit 1; }
echo "ok: a changed training picture changes the avatar"
