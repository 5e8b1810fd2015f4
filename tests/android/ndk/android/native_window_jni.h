// SPDX-License-Identifier: Apache-2.0
// A declaration of what we use of the NDK's android/native_window_jni.h, as its public reference documents it.
#pragma once

#include <jni.h>

struct ANativeWindow;
extern "C" ANativeWindow* ANativeWindow_fromSurface(JNIEnv* env, jobject surface);
extern "C" void ANativeWindow_release(ANativeWindow* window);
