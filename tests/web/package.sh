#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Unpacks the npm package as npm would and draws with it in Node, by its name.
#   package.sh PACKAGE.tgz PERSON.glb WORK      WORK: a folder, emptied before
set -euo pipefail
package="$1" person="$(realpath "$2")" work="$3"
here="$(cd "$(dirname "$0")" && pwd)"
rm -rf "$work"
mkdir -p "$work/node_modules/doppel-web"
tar -xzf "$package" -C "$work/node_modules/doppel-web" --strip-components=1
cp "$here/package_test.mjs" "$work/"
cd "$work"
WEB_PERSON="$person" node --test package_test.mjs
