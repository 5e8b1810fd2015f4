#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# on_swiftshader.sh PROGRAM [ARGUMENTS]: runs a test on the SwiftShader driver. Looks for it at DOPPEL_SWIFTSHADER_ICD, in build/drivers (where
# tools/prove-drivers --fetch puts it) and beside an installed chromium. Without the driver exits with 77, which CTest counts as skipped.
root=$(cd "$(dirname "$0")/../../.." && pwd)
for icd in "$DOPPEL_SWIFTSHADER_ICD" "$root/build/drivers/swiftshader/vk_swiftshader_icd.json" /usr/lib/chromium/vk_swiftshader_icd.json; do
    [ -f "$icd" ] || continue
    # Old loaders know only VK_ICD_FILENAMES.
    exec env VK_ICD_FILENAMES="$icd" VK_DRIVER_FILES="$icd" DOPPEL_VULKAN_DEVICE=SwiftShader "$@"
done
# Printed as GoogleTest prints a skip, because tools/lib.sh repeats the reason.
name=$(basename "$1")
echo "on_swiftshader.sh: Skipped"
echo "the SwiftShader driver is not here; tools/prove-drivers --fetch gets it"
echo "[  SKIPPED ] $name.onSwiftShader (0 ms)"
exit 77
