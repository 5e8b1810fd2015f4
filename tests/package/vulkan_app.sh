#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Vulkan program against the moved installation that run.cmake left, and runs it. Exit code 77: there is no Vulkan device.
# usage: vulkan_app.sh WORK SOURCE GENERATOR CXX_COMPILER
set -euo pipefail
work="$1" source="$2" generator="$3" cxx="$4"
rm -rf "$work/vulkan_app" "$work/vulkan_app_build"
cp -r "$source" "$work/vulkan_app"  # outside the source tree, so that it cannot find headers by accident
cmake -S "$work/vulkan_app" -B "$work/vulkan_app_build" -G "$generator" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$cxx" \
    -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/vulkan_app.log" 2>&1 || { cat "$work/vulkan_app.log"; exit 1; }
cmake --build "$work/vulkan_app_build" >"$work/vulkan_app.log" 2>&1 || { cat "$work/vulkan_app.log"; exit 1; }
exec "$work/vulkan_app_build/vulkan_app" "$work/tiny.glb" "$work/room.ppm"
