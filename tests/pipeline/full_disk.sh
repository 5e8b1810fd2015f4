#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A disk that becomes full in a late stage of a reconstruction: an error that names the file and the cause, no truncated file under its
# final name, and the same avatar when the run goes on with more room. tests/unit/doppel_cli/full_disk_test.sh tries the outputs of other
# commands and the first stage.
# usage: full_disk.sh DOPPEL WORKDIR [SCAN]     a finished run in WORKDIR/free is used again
set -euo pipefail
doppel="$1" work="$2"
mkdir -p "$work/disk"
cd "$work"
if ! mount -t tmpfs -o size=64m doppel-test disk 2>/dev/null; then
    echo "skipped: a small disk can be mounted by root alone"
    exit 77
fi
trap 'umount "$work/disk"' EXIT
scan="${3:-scan}"
if [ "$scan" = scan ] && [ ! -d scan ]; then
    "$doppel" sample -o scan --small --size 126x168 --seed 5 2>sample.log
fi
failures=0
reconstruct() { "$doppel" reconstruct "$scan" -o "$1" --preset draft --steps 20 --checkpoint-every 0.1 >out.log 2>&1; }
reconstruct free || { tail -n 5 out.log >&2; echo "FAILED: a run on a free disk" >&2; exit 1; }
# full ROOM STAGE...: without the results of these stages and with ROOM kB left a run must fail; with more room it must go on to the end.
full() {
    local room="$1" status=0 wrong="" output
    shift
    mount -o remount,size=64m disk
    rm -rf disk/run
    cp -a free disk/run
    rm -f disk/run/{avatar.glb,poses.json,report.html,report.json,verdict.json}
    for stage in "$@"; do rm -rf "disk/run/stages/$stage"; done
    mount -o remount,size=$(($(du -sk disk | cut -f1) + room))k disk
    reconstruct disk/run || status=$?
    cp out.log "full_${1:-outputs}.log"
    if [ $status -eq 0 ] || [ $status -ge 128 ]; then wrong="exit $status"; fi
    grep -q "cannot write .*disk/run/.*: No space left on device" out.log || wrong="$wrong, the sentence is: $(tail -n 1 out.log)"
    for output in avatar.glb poses.json; do  # what is there is whole
        [ ! -e "disk/run/$output" ] || cmp -s "disk/run/$output" "free/$output" || wrong="$wrong, $output is not whole"
    done
    [ ! -e disk/run/report.html ] || tail -c 20 disk/run/report.html | grep -q "</html>" || wrong="$wrong, report.html is not whole"
    local said
    said=$(tail -n 1 out.log)
    mount -o remount,size=64m disk
    reconstruct disk/run || wrong="$wrong, with more room: $(tail -n 1 out.log)"
    cmp -s disk/run/avatar.glb free/avatar.glb || wrong="$wrong, with more room the avatar is another one"
    [ -s disk/run/report.html ] || wrong="$wrong, with more room there is no report"
    if [ -n "$wrong" ]; then
        echo "FAILED: ${1:-outputs}: $wrong" >&2
        failures=$((failures + 1))
    else
        echo "ok: ${1:-outputs}: $(echo "$said" | cut -c1-160)"
    fi
}
full 600 co-optimise  # a checkpoint has no room
full 64 package
# The results of all stages are there, and the outputs beside them have no room: verdict.json, then the copy of the avatar.
full 8
full 64
[ $failures -eq 0 ]
