#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Every output on a disk that is too small: an error that names it, and no file under the name of the output.
# usage: full_disk_test.sh DOPPEL MAKE_TINY_AVATAR WORKDIR
set -euo pipefail
doppel="$1" make_tiny_avatar="$2" work="$3"
rm -rf "$work" && mkdir -p "$work/disk"
cd "$work"
if ! mount -t tmpfs -o size=64k doppel-test disk 2>/dev/null; then
    echo "skipped: a small disk can be mounted by root alone"
    exit 77
fi
trap 'umount "$work/disk"' EXIT
failures=0
kilobytes_left=0
# fails NAME OUTPUT COMMAND...: on the small disk COMMAND must exit with 1 … 127, say where, and leave nothing at OUTPUT.
fails() {
    local name="$1" output="disk/$2" status=0
    shift 2
    rm -rf disk/* disk/.[!.]*
    head -c $((64 - kilobytes_left))k /dev/zero >disk/filler 2>/dev/null || true
    "$@" >out.log 2>&1 || status=$?
    if [ $status -eq 0 ] || [ $status -ge 128 ]; then
        echo "FAILED: $name (exit $status): $(tail -n 3 out.log)" >&2
        failures=$((failures + 1))
    elif ! grep -qF "disk" out.log; then
        echo "FAILED: $name does not say where: $(tail -n 3 out.log)" >&2
        failures=$((failures + 1))
    elif [ -f "$output" ]; then
        echo "FAILED: $name left $output of $(stat -c %s "$output") bytes" >&2
        failures=$((failures + 1))
    else
        echo "ok: $name: $(tail -n 1 out.log | cut -c1-160)"
    fi
}
"$make_tiny_avatar" avatar.glb
"$doppel" sample -o scan --small --seed 5 2>/dev/null
render=("$doppel" render avatar.glb --renderer software --size 256x256)
fails "a picture" a.png "${render[@]}" -o disk/a.png
kilobytes_left=8
if command -v ffmpeg >/dev/null; then
    fails "a video" a.mp4 "${render[@]}" -o disk/a.mp4 --turntable
else
    echo "skipped: a video: ffmpeg is not installed"
fi
kilobytes_left=0
fails "frames of a video" frames "${render[@]}" -o disk/frames --turntable
fails "an export" a.ply "$doppel" export avatar.glb -o disk/a.ply
fails "a packed avatar" a.glb "$doppel" pack avatar.glb -o disk/a.glb --pictures 2
fails "a body" body.glb "$doppel" body import builtin -o disk/body.glb
fails "a sample scan" scan/scan.json "$doppel" sample -o disk/scan --small
fails "an import" photos/scan.json "$doppel" import scan/images -o disk/photos
kilobytes_left=8  # room for the lock, so that the first stage writes
fails "a check" run/avatar.glb "$doppel" check scan -o disk/run
fails "a reconstruction" run/avatar.glb "$doppel" reconstruct scan -o disk/run
[ $failures -eq 0 ]
