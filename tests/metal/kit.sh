#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# kit.sh CONFORMANCE CONFORMANCE_METAL WORK: the Metal backend, on the software device, passes the conformance kit with both fills.
set -eu
conformance=$1 draw=$2 work=$3
rm -rf "$work"
"$conformance" write "$work/kit"
status=0
for fill in quads tiles; do
    "$draw" "$work/kit" "$work/$fill" $fill || status=1
    "$conformance" score "$work/kit" "$work/$fill" || status=1
done
exit $status
