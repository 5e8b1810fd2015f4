// SPDX-License-Identifier: Apache-2.0
// A declaration of what we use of the NDK's android/log.h, as its public reference documents it.
#pragma once

enum { ANDROID_LOG_DEBUG = 3, ANDROID_LOG_INFO = 4, ANDROID_LOG_WARN = 5, ANDROID_LOG_ERROR = 6 };
extern "C" int __android_log_write(int priority, const char* tag, const char* text);
extern "C" __attribute__((format(printf, 3, 4))) int __android_log_print(int priority, const char* tag, const char* format, ...);
