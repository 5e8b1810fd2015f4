#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `doppel setup` without a network: what it says, asks, refuses and leaves. tests/models/fetch_test.py tries the fetch itself.
#   setup_test.sh DOPPEL MAKE_TINY_AVATAR FOLDER
set -euo pipefail
doppel="$1"
rm -rf "$3"
mkdir -p "$3/bin" "$3/empty"
cd "$3"
failures=0
expect() {  # expect NAME TEXT WORD...: every word is in the text
    local name="$1" text="$2" word
    shift 2
    for word in "$@"; do
        case "$text" in *"$word"*) ;; *) echo "FAILED: $name: no '$word' in: $text" >&2; failures=$((failures + 1)) ;; esac
    done
}
python=$(python3 -c 'import sys; print(sys.executable)')
ln -s "$python" bin/python3
run() {  # run ARGUMENTS: in a PATH of python3 and what a test adds; prints all output and the exit code
    local code=0
    env PATH="$PWD/bin" XDG_DATA_HOME="$PWD/share" https_proxy=http://127.0.0.1:9 HTTPS_PROXY=http://127.0.0.1:9 "$doppel" setup "$@" </dev/null 2>&1 || code=$?
    echo "exit $code"
}
expect "what is missing" "$(run --check)" "missing: networks" "138 MiB from registry.npmjs.org" "Apache-2.0" "MIT" "$PWD/share/doppel/models" \
    "missing: ffmpeg" "missing: COLMAP" "doppel setup gets it" "exit 1"
[ ! -e share ] || { echo "FAILED: --check made a folder" >&2; failures=$((failures + 1)); }
expect "nobody agrees" "$(run)" "say so with --yes" "exit 2"
expect "no network" "$(run --yes)" "cannot fetch from registry.npmjs.org" "Check the network" "exit 1"
echo "no archive" >broken.tgz
expect "another archive" "$(run --yes --package broken.tgz)" "SHA-256 differs" "Nothing was installed" "exit 1"
[ -e broken.tgz ] || { echo "FAILED: the user's archive is gone" >&2; failures=$((failures + 1)); }
expect "no such archive" "$(run --yes --package gone.tgz)" "gone.tgz" "exit 2"
rm bin/python3
expect "no python" "$(run --yes)" "python3 is missing" "exit 1"
[ $failures -eq 0 ]
