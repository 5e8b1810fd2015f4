#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/bootstrap installs its two lists, or that of the SDK alone; each list is sorted, and no package is in both: bootstrap_packages.sh ROOT
set -euo pipefail
cd "$1"
export LC_ALL=C
sort --check --unique tools/packages-sdk.txt
sort --check --unique tools/packages.txt
both=$(comm -12 tools/packages-sdk.txt tools/packages.txt)
[ -z "$both" ] || { echo "in both lists: $both" >&2; exit 1; }

bare=$(mktemp -d)  # as on a machine where no package is installed
trap 'rm -rf "$bare"' EXIT
printf '#!/bin/sh\nexit 1\n' >"$bare/dpkg-query"
chmod +x "$bare/dpkg-query"
asked() { { PATH="$bare:$PATH" tools/bootstrap --check "$@" 2>/dev/null || true; } | sed -n 's/^missing: //p' | tr ' ' '\n'; }
diff tools/packages-sdk.txt <(asked --sdk)
# Node may come from elsewhere, and is then not asked for.
diff <(cat tools/packages-sdk.txt tools/packages.txt | grep -vE '^(nodejs|npm)$') <(asked | grep -vE '^(nodejs|npm)$')
