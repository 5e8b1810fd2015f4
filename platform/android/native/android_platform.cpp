// SPDX-License-Identifier: Apache-2.0
#define VK_USE_PLATFORM_ANDROID_KHR
#include <android/log.h>
#include <android/native_window_jni.h>
#include <doppel/doppel.h>
#include <vulkan/vulkan.h>

#include "platform/android/native/jni_platform.h"
#include "platform/common/errors.h"

namespace dpl::android {

Window windowOf(JNIEnv* env, jobject surface) {
    ANativeWindow* window = ANativeWindow_fromSurface(env, surface);
    if (!window) return {};
    return Window(window, ANativeWindow_release);
}

std::vector<const char*> surfaceExtensions() {
    return {VK_KHR_SURFACE_EXTENSION_NAME, VK_KHR_ANDROID_SURFACE_EXTENSION_NAME};
}

doppel::Result<VkSurfaceKHR> makeSurface(VkInstance instance, ANativeWindow* window) {
    VkAndroidSurfaceCreateInfoKHR info{VK_STRUCTURE_TYPE_ANDROID_SURFACE_CREATE_INFO_KHR};
    info.window = window;
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    DPL_VK(vkCreateAndroidSurfaceKHR(instance, &info, nullptr, &surface));
    return surface;
}

void sendLogToSystem() {
    dplSetLogCallback(
        [](void*, DplLogLevel level, const char* text) {
            constexpr int kPriorities[] = {ANDROID_LOG_DEBUG, ANDROID_LOG_INFO, ANDROID_LOG_WARN, ANDROID_LOG_ERROR};
            __android_log_write(level >= DPL_LOG_DEBUG && level <= DPL_LOG_ERROR ? kPriorities[level] : ANDROID_LOG_INFO, "doppel", text);
        },
        nullptr);
}

}  // namespace dpl::android
