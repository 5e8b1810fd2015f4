#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The module in Node: its tests, and the conformance kit against this machine's CPU renderer.
#   node.sh MODULE REFEREE DOPPEL CONFORMANCE WORK
# Then the npm package, imported by its name, and the parts of pages that hold a person in themselves.
# The last four: the programs web_referee, doppel and conformance, and a folder. Exit code 77: there is no module, or no Node.
set -euo pipefail
module="$1" referee="$2" doppel="$3" conformance="$4" work="$5"
here="$(cd "$(dirname "$0")" && pwd)"
[ -e "$module" ] || { echo "skipped: there is no $module; tools/prove-web builds it"; exit 77; }
command -v node >/dev/null || { echo "skipped: node is not installed"; exit 77; }
mkdir -p "$work/referee"
"$doppel" sample-avatar -o "$work/person.glb" >"$work/person.log" 2>&1 || { cat "$work/person.log" >&2; exit 1; }
(cd "$work/referee" && node --input-type=module -e \
    "import { SHOTS, line } from 'file://$here/shots.mjs'; for (const shot of SHOTS) console.log(line(shot, shot.name + '.rgba'))" |
    "$referee" "$work/person.glb")
WEB_MODULE="$module" WEB_PERSON="$work/person.glb" WEB_REFEREE="$work/referee" WEB_REFEREE_PROGRAM="$referee" \
    node --test "$here/module_test.mjs" "$here/tracking_test.mjs"
WEB_MODULE="$module" node --test "$here/page_parts_test.mjs"
rm -rf "$work/npm"  # of another version
python3 "$here/../../tools/packaging/npm.py" "$(dirname "$module")" "$work/npm" "$("$doppel" --version | cut -d' ' -f2)" 0
"$here/package.sh" "$work"/npm/doppel-web-*.tgz "$work/person.glb" "$work/package"
"$conformance" write "$work/kit"
"$conformance" draw "$work/kit" "$work/library" --renderer software
node "$here/draw_kit.mjs" "$module" "$work/kit" "$work/module"
"$conformance" compare "$work/kit" "$work/library" "$work/module"
