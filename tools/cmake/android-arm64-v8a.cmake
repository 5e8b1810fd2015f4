# SPDX-License-Identifier: Apache-2.0
# Toolchain file for Android 10 by the NDK, with what `tools/deps android-arm64-v8a` built and unpacked.
set(ANDROID_ABI arm64-v8a)
set(ANDROID_PLATFORM android-29)
set(ANDROID_STL c++_static)
include($ENV{ANDROID_NDK_HOME}/build/cmake/android.toolchain.cmake)
