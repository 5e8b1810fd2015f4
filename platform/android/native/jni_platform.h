// SPDX-License-Identifier: Apache-2.0
// What the natives need of Android itself. android_platform.cpp does it; tests/android has a body for the desktop JVM.
#pragma once

#include <jni.h>

#include "platform/android/native/window_surface.h"

namespace dpl::android {

/** The window of an android.view.Surface, kept alive by the result. Empty if the surface has been released. */
Window windowOf(JNIEnv* env, jobject surface);

/** Sends the library's log to the system's log, under the tag "doppel". */
void sendLogToSystem();

}  // namespace dpl::android
