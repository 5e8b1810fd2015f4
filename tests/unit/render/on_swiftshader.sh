#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# on_swiftshader.sh PROGRAM [ARGUMENTS]: runs a test on the SwiftShader driver, found in build/drivers (tools/prove-drivers --fetch puts it there),
# beside an installed chromium, or where DOPPEL_SWIFTSHADER_ICD points. Exits with 77, which CTest counts as skipped, where there is none.
root=$(cd "$(dirname "$0")/../../.." && pwd)
for icd in "$DOPPEL_SWIFTSHADER_ICD" "$root/build/drivers/swiftshader/vk_swiftshader_icd.json" /usr/lib/chromium/vk_swiftshader_icd.json; do
    [ -f "$icd" ] || continue
    # Old loaders know only the first name.
    exec env VK_ICD_FILENAMES="$icd" VK_DRIVER_FILES="$icd" DOPPEL_VULKAN_DEVICE=SwiftShader "$@"
done
# The form in which GoogleTest reports a skip: tools/lib.sh repeats the reason.
name=$(basename "$1")
echo "on_swiftshader.sh: Skipped"
echo "the SwiftShader driver is not here; tools/prove-drivers --fetch gets it"
echo "[  SKIPPED ] $name.onSwiftShader (0 ms)"
exit 77
