// SPDX-License-Identifier: Apache-2.0
// A declaration of what we use of the NDK's android_native_app_glue.h, android/native_activity.h and android/looper.h, as its public
// reference documents it.
#pragma once

#include <jni.h>

struct AAssetManager;
struct ANativeActivity {
    JavaVM* vm;
    jobject clazz;  // the activity itself
    AAssetManager* assetManager;
};
extern "C" void ANativeActivity_finish(ANativeActivity* activity);
extern "C" int ALooper_pollOnce(int timeoutMs, int* fd, int* events, void** data);

struct android_app;
struct android_poll_source {
    void (*process)(android_app* app, android_poll_source* source);
};
struct android_app {
    ANativeActivity* activity;
    int destroyRequested;
};
extern "C" void android_main(android_app* app);
