#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tools refuse options that they do not know, before they start to work: tool_options.sh ROOT
set -uo pipefail
failures=0
for tool in api-docs bootstrap conformance packaging/android-aar prove-debian prove-gpu prove-release release test; do
    said=$(timeout 600 "$1/tools/$tool" --bogus 2>&1)
    status=$?
    case "$status $said" in
        "2 tools/$tool: unknown option '--bogus'"*) ;;
        *) echo "tools/$tool --bogus: exit code $status, '$said'" >&2; failures=1 ;;
    esac
done
exit $failures
