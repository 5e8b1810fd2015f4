#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `doppel share`: where an installed program looks for the web module, and what it refuses. tests/web opens its page in a browser.
#   share_test.sh DOPPEL MAKE_TINY_AVATAR FOLDER
set -euo pipefail
rm -rf "$3"
mkdir -p "$3/prefix/bin" "$3/run" "$3/empty"
cp "$1" "$3/prefix/bin/doppel"
"$2" "$3/tiny.glb"
cd "$3"
failures=0
failed() { echo "FAILED: $1" >&2; failures=$((failures + 1)); }
# says CODE TEXT WORDS...: `doppel share WORDS` ends with this code and these words.
says() {
    local code=$1 text="$2" status=0
    shift 2
    prefix/bin/doppel share "$@" >out.log 2>&1 </dev/null || status=$?
    if [ $status -eq "$code" ] && grep -qE -- "$text" out.log; then echo "ok: share $*"; else failed "share $* (exit $status): $(tail -n 3 out.log)"; fi
}
says 1 "share/doppel/web/page/doppel.wasm.lzma, a part of the web module; install the package doppel-tools, or build it" tiny.glb -o ada.html
[ ! -e ada.html ] || failed "a page without a module"

web=prefix/share/doppel/web/page
mkdir -p $web
printf ']\0\0\0\4aaaaaaaaaaaaaaaaaaaa' >$web/doppel.wasm.lzma
echo "console.log(1);" >$web/live-bundle.js
echo "#person{margin:0}" >$web/live.css
says 0 "ada.html: [0-9]+ bytes, of them [0-9]+ for the avatar" tiny.glb -o ada.html
grep -q "<title>ada</title>" ada.html || failed "the page is not called as its file"
cp tiny.glb run/avatar.glb
says 0 "bytes" run -o of-run.html --name ada
cmp ada.html of-run.html || failed "a run and its avatar give different pages"
says 1 "empty holds no avatar.glb; finish its run" empty -o no.html
says 1 "nobody.glb" nobody.glb -o no.html
says 2 "tiny.glb|\.html" tiny.glb -o tiny.glb
says 2 "html" tiny.glb -o ada.txt
head -c 700 tiny.glb >cut.glb
says 1 "cut.glb" cut.glb -o no.html
printf 'ply\nformat binary_little_endian 1.0\nelement vertex 0\nend_header\n' >general.ply
says 1 "general.ply" general.ply -o no.html
[ ! -e no.html ] || failed "an error left a page"
exit $failures
