#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# validate_files.sh NPM_FOLDER FILE...: installs gltf-validator into NPM_FOLDER when it is not there and runs it. Exit 77: skipped.
folder=$1
shift
if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
    echo "skipped: node and npm are not installed (apt-get install nodejs npm)"
    exit 77
fi
if [ ! -d "$folder/node_modules/gltf-validator" ]; then
    mkdir -p "$folder"
    if ! timeout 600 npm install --prefix "$folder" --no-fund --no-audit --silent gltf-validator@2.0.0-dev.3.10 >"$folder/npm.log" 2>&1; then
        echo "skipped: gltf-validator could not be installed from the npm registry:"
        tail -3 "$folder/npm.log"
        exit 77
    fi
fi
exec node "$(dirname "$0")/validate_gltf.mjs" "$folder" "$@"
