#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# doppel-xr on the mock runtime: alone and in its room, with one image for both eyes and with one each, in a mirror. Its captures must equal dplRender.
# Exit code 77: there is no Vulkan device.
# usage: app_on_mock.sh WORK MAKE_AVATAR DOPPEL_XR COMPARE
set -euo pipefail
work="$1" make_avatar="$2" doppel_xr="$3" compare="$4"
rm -rf "$work"
mkdir -p "$work"
"$make_avatar" "$work/tiny.glb"
validate=--validate
[ -e /usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json ] || { validate=""; echo "no Vulkan validation layer here"; }
app() {
    local folder="$1" status=0
    shift
    "$doppel_xr" "$work/tiny.glb" --frames 4 $validate --capture "$work/$folder" "$@" >"$work/$folder.log" 2>&1 || status=$?
    if [ $status != 0 ]; then
        cat "$work/$folder.log"
        if grep -q "could not create a Vulkan instance" "$work/$folder.log"; then exit 77; fi  # no driver
        exit 1
    fi
}
app alone --without-room --clip turn
"$compare" "$work/tiny.glb" "$work/alone"
app each_eye --without-room --per-eye
"$compare" "$work/tiny.glb" "$work/each_eye"
app mirror --without-room --clip turn --mirror  # the square has neither head nor hands, so its pose is the clip's
"$compare" "$work/tiny.glb" "$work/mirror"
app room --without-avatar
app together
"$compare" "$work/tiny.glb" "$work/together" "$work/room"
