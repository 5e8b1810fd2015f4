// SPDX-License-Identifier: Apache-2.0
// The jni.h of a JDK, with JavaVM as the NDK declares it: AttachCurrentThread takes JNIEnv**, not void**.
#pragma once

#define JavaVM JdkJavaVM
#define JNI_OnLoad JdkJNI_OnLoad
#include_next <jni.h>
#undef JNI_OnLoad
#undef JavaVM

struct JavaVM {
    jint GetEnv(void** env, jint version);
    jint AttachCurrentThread(JNIEnv** env, void* arguments);
    jint DetachCurrentThread();
};
