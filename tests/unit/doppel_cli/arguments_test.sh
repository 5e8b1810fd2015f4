#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Arguments that `doppel` refuses before any work: exit code 2, a sentence, and no file changed.
# usage: arguments_test.sh DOPPEL MAKE_TINY_AVATAR WORKDIR
set -euo pipefail
doppel="$1" make_tiny_avatar="$2" work="$3"
rm -rf "$work" && mkdir -p "$work"
cd "$work"
failures=0
failed() { echo "FAILED: $1" >&2; failures=$((failures + 1)); }
# refuses PATTERN WORDS...: `doppel WORDS` must exit with 2 and print PATTERN.
refuses() {
    local pattern="$1" status=0
    shift
    "$doppel" "$@" >out.log 2>&1 </dev/null || status=$?
    if [ $status -eq 2 ] && grep -qE -- "$pattern" out.log; then echo "ok: $*"; else failed "$* (exit $status): $(tail -n 3 out.log)"; fi
}

"$make_tiny_avatar" a.glb
cp a.glb b.glb
ln -s a.glb link.glb
cp a.glb kept
refuses "a.glb is the input a.glb itself; choose another -o" export a.glb -o a.glb
refuses "b.glb is the input b.glb itself" export a.glb --clip b.glb -o b.glb
refuses "link.glb is the input a.glb itself" pack a.glb -o link.glb
refuses "a.glb is the input link.glb itself" dress link.glb --top b.glb -o a.glb
refuses "b.glb is the input ./b.glb itself" dress a.glb --top ./b.glb -o b.glb
for file in a.glb b.glb; do cmp -s $file kept || failed "$file was overwritten"; done

mkdir scan
ln -s scan scan-link
for command in reconstruct check cameras; do
    refuses "scan-link is the input scan itself; choose another -o" $command scan -o scan-link
done
refuses "scan is the input ./scan itself" cameras blind --truth ./scan -o scan
[ -z "$(ls scan)" ] || failed "stages were written into the scan: $(ls scan)"

for out in views.png views.mp4; do refuses "$out: with --scan the output is a folder" render a.glb --scan scan -o $out; done
[ ! -e views.png ] && [ ! -e views.mp4 ] || failed "a refused render made its output"

echo '{"step": 100}' >mine.json
refuses "mine.json: a preset has no 'step' \(did you mean 'steps'\?\)" reconstruct scan -o out --preset mine.json
refuses "there is no preset and no file 'hihg'" reconstruct scan -o out --preset hihg
refuses "'quick' is no engine; cpu, gpu, gpu:NAME with a part of the GPU's name, and auto are" reconstruct scan -o out --engine quick
refuses "--out requires preset" presets -o mine.json
refuses "mine.json is the input mine.json itself" presets mine.json -o mine.json
[ ! -e out ] || failed "a refused run made its output"

touch a.png
refuses "-o: a.png is there already" render a.glb
refuses "-o: --scan draws many pictures; name a folder" render a.glb --scan scan
[ ! -s a.png ] || failed "a picture that nobody named was overwritten"
rm a.png

for option in "--split train" "--poses p.json" "--scale 2" --without-pose-fit; do
    # shellcheck disable=SC2086  # an option and its value are words
    refuses "${option%% *} requires --scan" render a.glb -o a.png $option
done
for option in "--size 8x8" --stereo --turntable "--seconds 1" "--clip walk" "--time 1" "--azimuth 5"; do
    # shellcheck disable=SC2086
    refuses "excludes" render a.glb -o views --scan scan $option
done
refuses "--time requires --clip" export a.glb -o a.ply --time 1
for option in "--time 1" "--fps 30"; do
    # shellcheck disable=SC2086
    refuses "${option%% *} excludes --mesh" export a.glb -o m.glb --mesh --clip walk $option
done
for option in "--texture-size 512" "--texture-format jpg" "--compress draco"; do
    # shellcheck disable=SC2086
    refuses "${option%% *} requires --mesh" export a.glb -o m.glb $option
done
refuses "--vrm requires --mesh" export a.glb -o m.vrm --vrm --author Ada
refuses "--vrm requires --author" export a.glb -o m.vrm --mesh --vrm
refuses "--author requires --vrm" export a.glb -o m.glb --mesh --author Ada
refuses "--author: 1 required TEXT missing" export a.glb -o m.vrm --mesh --vrm --author=
refuses "with --vrm the file must end in .vrm" export a.glb -o m.glb --mesh --vrm --author Ada
refuses "with --mesh the file must end in .glb" export a.glb -o m.vrm --mesh
for side in 0 128 1000 16384 2k -1; do
    refuses "'$side' is no power of two from 256 to 8192" export a.glb -o m.glb --mesh --texture-size=$side
done
for option in --turntable "--seconds 2"; do
    # shellcheck disable=SC2086
    refuses "a.png is one picture, and ${option%% *} makes many" render a.glb -o a.png $option
done

for seed in -1 18446744073709551616 1.5; do
    refuses "'$seed' is not a whole number" sample -o new --seed=$seed
    refuses "'$seed' is not a whole number" pack a.glb -o c.glb --seed=$seed
    refuses "'$seed' is not a whole number" reconstruct scan -o out --seed=$seed
done
refuses "'-1' is not a whole number" render a.glb -o a.png --splat-budget=-1

for command in reconstruct check; do refuses "--body.*nowhere.glb" $command scan -o out --body nowhere.glb; done
[ ! -e out ] || failed "a refused run made its output folder"

# Beyond the size that `ulimit -f` allows (KiB) the write fails with a sentence.
for words in "render a.glb -o big.png --size 600x600 --renderer software" "export a.glb -o big.ply"; do
    status=0
    # shellcheck disable=SC2086
    (ulimit -f 0 && "$doppel" $words 2>&1) | cat >out.log || status=$?
    if [ $status -eq 1 ] && grep -q "big.*File too large" out.log; then
        echo "ok: $words"
    else
        failed "$words (exit $status): $(cat out.log)"
    fi
done

[ $failures -eq 0 ] || { echo "$failures failed" >&2; exit 1; }
