#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What shells and scripts see of `doppel`: completion, the manual page, --json and --quiet.
# usage: shell_test.sh DOPPEL MAKE_TINY_AVATAR WORKDIR
set -euo pipefail
doppel="$1" make_tiny_avatar="$2" work="$3"
rm -rf "$work" && mkdir -p "$work"
cd "$work"
failures=0
# is NAME ACTUAL EXPECTED
is() {
    if [ "$2" = "$3" ]; then echo "ok: $1"; else echo "FAILED: $1: '$2' instead of '$3'" >&2; failures=$((failures + 1)); fi
}

"$doppel" completion bash >doppel.bash
. ./doppel.bash
completions() {  # of the last word of the line
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
    _doppel
    echo "${COMPREPLY[*]}"
}
touch scan-a.mp4 scan-b.mp4
is "commands" "$(completions doppel recon)" "reconstruct"
is "commands of a command" "$(completions doppel body im)" "import"
is "options" "$(completions doppel reconstruct --pre)" "--preset"
is "options of a command's command" "$(completions doppel body import --o)" "--out"
is "values" "$(completions doppel reconstruct --preset d)" "draft"
is "every value" "$(completions doppel render --renderer "" | wc -w)" 3
is "files" "$(completions doppel render scan- | tr ' ' '\n' | sort | paste -sd ' ')" "scan-a.mp4 scan-b.mp4"
is "a command of a command that takes a file" "$(completions doppel bench trai)" "training"
is "the file of a command that has commands" "$(completions doppel bench scan-a)" "scan-a.mp4"
is "values of an argument" "$(completions doppel completion "")" "bash zsh"
is "a command without arguments takes no file" "$(completions doppel manual scan-)" ""
is "nothing for a number" "$(completions doppel reconstruct --steps "")" ""

"$doppel" completion zsh >_doppel
if command -v zsh >/dev/null; then
    is "zsh reads the script" "$(zsh -fc 'autoload -Uz compinit && compinit -u -D && source ./_doppel && print $_comps[doppel]' 2>&1)" "_doppel"
else
    echo "skipped: zsh reads the script: zsh is not installed"
fi

"$doppel" manual >doppel.1
for command in $("$doppel" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    [ "$command" = body ] && continue  # its two commands have sections of their own
    is "the manual has $command" "$(grep -c "^\.SS $command$" doppel.1)" 1
done
if command -v groff >/dev/null; then
    is "the manual is clean" "$(groff -man -Tutf8 -ww -z doppel.1 2>&1)" ""
else
    echo "skipped: the manual is clean: groff is not installed"
fi

"$make_tiny_avatar" avatar.glb
# Too little memory for the first thread. The least limit under which the program starts is looked for.
for ((megabytes = 20; megabytes < 600; megabytes += 2)); do
    said=$( (ulimit -v $((megabytes * 1024)); "$doppel" inspect avatar.glb) 2>&1) && break
    case "$said" in *"no thread can be started"* | *"Resource temporarily unavailable"*) break ;; esac
done
case "$said" in
    *"doppel: no thread can be started"*"ulimit -v"*) echo "ok: too little memory for a thread: at $megabytes MB" ;;
    *) echo "FAILED: too little memory for a thread: '$said'" >&2; failures=$((failures + 1)) ;;
esac
is "render --json" "$("$doppel" render avatar.glb -o a.png --size 32x32 --renderer software --json 2>/dev/null |
    python3 -c 'import json, sys; d = json.load(sys.stdin); print(d["out"], d["frames"], bool(d["renderer"]))')" "a.png 1 True"
is "pack --json" "$("$doppel" pack avatar.glb -o small.glb --pictures 2 --json 2>/dev/null |
    python3 -c 'import json, os, sys; d = json.load(sys.stdin); print(d["bytes"] == os.path.getsize(d["file"]) == d["curve"][-1]["bytes"])')" "True"
error_of() { python3 -c 'import json, sys; e = json.load(sys.stdin)["error"]; print(e["code"], sys.argv[1] in e["message"])' "$1"; }
(mkdir bare && cd bare && "$doppel" render ../avatar.glb --size 32x32 --renderer software --quiet)
is "render without -o names its picture" "$(ls bare)" "avatar.png"
is "errors as JSON" "$("$doppel" render nowhere.glb -o a.png --json 2>/dev/null | error_of nowhere.glb)" "not-found True"
is "wrong arguments as JSON" "$("$doppel" render avatar.glb -o a.gif --json 2>/dev/null | error_of a.gif)" "invalid-argument True"
is "an unknown option as JSON" "$("$doppel" reconstruct scan -o out --json --presett draft 2>/dev/null | error_of --presett)" \
    "invalid-argument True"
is "an unknown command as JSON" "$("$doppel" rendr --json 2>/dev/null | error_of rendr)" "invalid-argument True"
is "wrong arguments without --json leave standard output empty" "$("$doppel" render avatar.glb -o a.gif 2>/dev/null)" ""
verbose() { "$doppel" "$@" --verbose 2>&1 >/dev/null; }
is "render --verbose" "$(verbose render avatar.glb -o a.png --size 32x32 --renderer software | grep -cE 'splats of|ms a frame')" 2
is "pack --verbose" "$(verbose pack avatar.glb -o small.glb --pictures 2 | grep -c trying | awk "{print (\$1 > 2)}")" 1
is "--quiet" "$("$doppel" render avatar.glb -o a.png --size 32x32 --renderer software --quiet 2>&1)" ""
frames() { "$doppel" render avatar.glb -o frames --turntable --seconds "$1" --fps 10 --size 16x16 --renderer software 2>&1 >/dev/null; }
frames 0.5 >/dev/null
touch frames/plan.png frames/1.png frames/00007.txt frames/000003.png
is "fewer frames than before say so" "$(frames 0.3 | grep -o 'removed 5 frames of an earlier run')" "removed 5 frames of an earlier run"
is "no frame of an earlier run stays, and no other file goes" "$(LC_ALL=C ls frames | paste -sd ' ')" \
    "00000.png 000003.png 00001.png 00002.png 00007.txt 1.png plan.png"
[ $failures -eq 0 ] || { echo "$failures failed" >&2; exit 1; }
