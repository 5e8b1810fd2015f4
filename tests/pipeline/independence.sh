#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tests what an avatar depends on, with a small procedural scan. The avatar must have
#   the same bytes on 1 and 3 threads; after a stop, a kill -9 and a rerun; with every truth file removed; with every held-out image, mask,
#   label picture and keypoint replaced by noise;
#   the same bytes when it is trained with noise in every validation image; the evidence alone sees these images;
#   different bytes when one training image changes. This shows that the comparison can fail.
# usage: independence.sh DOPPEL WORKDIR
set -euo pipefail
doppel="$1" work="$2"
rm -rf "$work" && mkdir -p "$work"
cd "$work"
"$doppel" sample -o scan --small --size 126x168 --seed 5 2>sample.log
# Small pictures. Keeps half of the still frames, and moving ones until 20 train, so that some are set aside for validation. This halves the time.
python3 - <<'P'
import json, pathlib
path = pathlib.Path("scan/scan.json")
scan = json.loads(path.read_text())
seen = {}
def keeps(frame):
    count = seen[frame["kind"]] = seen.get(frame["kind"], 0) + 1
    return count <= 22 if frame["kind"] == "dynamic" else count % 2 == 1 or frame["split"] == "test"
scan["frames"] = [f for f in scan["frames"] if keeps(f)]
assert {("static_full", "test"), ("static_closeup", "train"), ("dynamic", "train"), ("dynamic", "test")} <= {(f["kind"], f["split"]) for f in scan["frames"]}
path.write_text(json.dumps(scan))
P
options=(--preset draft --steps 120 --seed 3)
failed() { echo "FAILED: $1" >&2; exit 1; }
# reconstruct SCAN OUT [options]: stops the run once avatar.glb exists, before held-out poses and the report. The file is written atomically.
reconstruct() {
    "$doppel" reconstruct "$1" -o "$2" "${options[@]}" "${@:3}" >>"$2.log" 2>&1 &
    local pid=$!
    while kill -0 $pid 2>/dev/null && [ ! -f "$2/avatar.glb" ]; do sleep 0.2; done
    kill -TERM $pid 2>/dev/null || true  # it may have ended already
    wait $pid 2>/dev/null || true        # the exit code of a stopped run means nothing; the file is checked below
    [ -f "$2/avatar.glb" ] || { tail -n 20 "$2.log" >&2; failed "reconstruct $2 made no avatar"; }
}
same() { cmp -s "$1/avatar.glb" "$2/avatar.glb" && echo "ok: $3" || failed "$3: $1/avatar.glb and $2/avatar.glb differ"; }

reconstruct scan one --threads 1
# Makes the poses and the report too, on more threads.
"$doppel" reconstruct scan -o one "${options[@]}" >>one.log 2>&1 || { tail -n 20 one.log >&2; failed "the rest of reconstruct one"; }
[ -f one/report.html ] || failed "no report"
last=$(tail -n 1 one.log)
said=": one/avatar.glb is done. Open one/report.html to see it and what to film again."
case "$last" in "Good$said" | "Usable$said" | "Film again$said") ;; *) failed "the last line is for nobody who filmed: $last" ;; esac
# hide SCAN: removes everything that docs/formats/scan.md marks as for measuring only, makes `xy` wrong, and gives keypoints their older name.
hide() {
    rm -rf "$1"/truth.json "$1"/geometry "$1"/posed "$1"/hires
    python3 - "$1" <<'P'
import json, pathlib, sys
root = pathlib.Path(sys.argv[1])
for path in root.glob("keypoints/*.json"):
    data = json.loads(path.read_text())
    data["xy"] = [[7, 7]] * len(data.pop("xy"))  # wrong, to show that nothing reads it
    data["xy_noisy"] = data.pop("detections")  # the name in older scans
    path.write_text(json.dumps(data))
scan = json.loads((root / "scan.json").read_text())
scan.pop("truth", None)
scan.pop("geometry", None)
if "skeleton" in scan:
    scan["skeleton"].pop("rest_positions", None)
(root / "scan.json").write_text(json.dumps(scan))
P
}
cat >png.py <<'P'
import struct, zlib
def png(path, width, height, channels, value):
    rows = b"".join(b"\0" + value(width * channels) for _ in range(height))
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    header = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))
P
export PYTHONPATH=.
# deceive SCAN: replaces held-out observations by noise of the same size. The files stay readable; an image may be a PNG under any name.
deceive() {
    python3 - "$1" <<'P'
import json, pathlib, random, sys
from png import png
random.seed(1)
def among(values):
    return lambda count: bytes(random.choices(values, k=count))
root = pathlib.Path(sys.argv[1])
scan = json.loads((root / "scan.json").read_text())
width, height = scan["image_size"]
changed = 0
for frame in scan["frames"]:
    if frame["split"] != "test":
        continue
    before = (root / frame["image"]).read_bytes()
    png(root / frame["image"], width, height, 3, random.randbytes)
    png(root / frame["mask"], width, height, 1, among((0, 255)))
    png(root / frame["labels"], width, height, 1, among(range(6)))
    keypoints = json.loads((root / frame["keypoints"]).read_text())
    for name in ("xy_noisy", "detections"):
        if name in keypoints:
            keypoints[name] = [[random.uniform(0, width), random.uniform(0, height)] for _ in keypoints[name]]
    (root / frame["keypoints"]).write_text(json.dumps(keypoints))
    changed += (root / frame["image"]).read_bytes() != before
assert changed >= 3, changed
P
}
# poison SCAN: replaces validation images by noise, and keeps them in validation/.
poison() {
    python3 - "$1" one/poses.json <<'P'
import json, pathlib, random, shutil, sys
from png import png
random.seed(2)
root = pathlib.Path(sys.argv[1])
scan = json.loads((root / "scan.json").read_text())
width, height = scan["image_size"]
chosen = {f["name"] for f in json.load(open(sys.argv[2]))["frames"] if f["split"] == "validation"}
assert chosen, "no frame was set aside for validation"
(root / "validation").mkdir()
for frame in scan["frames"]:
    if frame["name"] in chosen:
        assert frame["split"] == "train", frame
        shutil.move(root / frame["image"], root / "validation")
        png(root / frame["image"], width, height, 3, random.randbytes)
P
}
# One run differs in all three things that must not matter. If its bytes differ, a run for each of them tells which does.
cp -r scan apart
hide apart
deceive apart
poison apart
reconstruct apart all --threads 3
cmp -s one/stages/evidence/evidence.json all/stages/evidence/evidence.json && failed "the evidence does not look at validation images"
echo "ok: noise for validation images gives other evidence"
# With the true validation images again, only evidence and package run anew, on what was trained beside the noise.
cp all/stages/co-optimise/trained.bin trained-beside-noise.bin
mv apart/validation/* apart/images/
rm all/avatar.glb
reconstruct apart all --threads 3
cmp -s trained-beside-noise.bin all/stages/co-optimise/trained.bin || failed "validation images are inputs of training"
if cmp -s one/avatar.glb all/avatar.glb; then
    echo "ok: 3 threads, no truth files, keypoints under their older name, noise for held-out images, masks, labels and keypoints, and"
    echo "    training beside noise for validation images: same bytes"
else
    reconstruct scan three --threads 3
    same one three "1 and 3 threads give the same bytes"
    cp -r scan hidden
    hide hidden
    reconstruct hidden blind
    same one blind "without any truth file, and with keypoints under their older name, the bytes are the same"
    failed "held-out images, masks, labels or keypoints, or validation images in training, reach the avatar"
fi

# Stops a run in training, after a checkpoint; continues and kills it; continues it again. One thread makes training longer. The stages
# before training are those of the first run, which saves a minute.
mkdir -p killed/stages
cp -r one/stages/{ingest,body-fit,surface,body-map,garments,register} killed/stages
checkpoint=killed/stages/co-optimise.work/checkpoint
# signalled SIGNAL CONDITION: starts a run that writes a checkpoint every 100 steps, and sends it SIGNAL once CONDITION holds. It must end in
# training and leave a checkpoint. When training has ended before the signal came, as may happen on a busy machine, it starts over.
signalled() {
    rm -rf before && cp -r killed before
    for _ in $(seq 20); do
        "$doppel" reconstruct scan -o killed "${options[@]}" --threads 1 --checkpoint-every 0 >$1.log 2>&1 &
        local pid=$! ended=0
        until eval "$2" || ! kill -0 $pid 2>/dev/null; do sleep 0.02; done
        kill -$1 $pid 2>/dev/null || true
        wait $pid || ended=$?
        eval "$2" || { tail -n 20 $1.log >&2; failed "a run ended before: $2"; }
        if [ -f $checkpoint ]; then
            [ $ended -ne 0 ] || failed "a run that was ended by SIG$1 must not exit with 0"
            return
        fi
        [ -d killed/stages/co-optimise ] || failed "SIG$1 in training, and no checkpoint is left"
        rm -rf killed && cp -r before killed
    done
    failed "20 times, SIG$1 came after training"
}
signalled TERM "[ -f $checkpoint ] || [ -d killed/stages/co-optimise ]"
tail -n 1 TERM.log | grep -Eq "run the same command again to go on|^doppel: stopped$" || failed "a stopped run does not say how to go on"
echo "ok: stopped in training, checkpoint kept"
signalled KILL 'grep -q "continuing at step" KILL.log'
reconstruct scan killed
grep -q "continuing at step" killed.log || failed "a killed run must continue at its checkpoint"
same one killed "a stopped and killed run continues to the same bytes"

# One changed training picture changes the avatar, so the comparison can fail.
cp -r scan changed
first=$(python3 -c "import json; print([f['image'] for f in json.load(open('scan/scan.json'))['frames'] if f['split'] == 'train'][0])")
second=$(python3 -c "import json; print([f['image'] for f in json.load(open('scan/scan.json'))['frames'] if f['split'] == 'train'][5])")
cp "scan/$second" "changed/$first"
reconstruct changed other
cmp -s one/avatar.glb other/avatar.glb && failed "a changed training picture changed nothing"
echo "ok: a changed training picture changes the avatar"
