// SPDX-License-Identifier: Apache-2.0
// The body of jni_platform.h and window_surface.h on a desktop JVM: windows are those of FakeWindow.java, which tests make.
#include <doppel/doppel.h>
#include <vulkan/vulkan.h>

#include <cstring>
#include <string>

#include "platform/android/native/jni_platform.h"
#include "platform/common/errors.h"
#include "tests/android/fake_window.h"

namespace dpl::android {

Window windowOf(JNIEnv* env, jobject surface) {
    jclass type = env->GetObjectClass(surface);
    const jlong number = env->GetLongField(surface, env->GetFieldID(type, "number", "J"));
    env->DeleteLocalRef(type);
    auto* window = reinterpret_cast<ANativeWindow*>(number);
    if (!window) return {};  // released
    ++window->users;
    return Window(window, [](ANativeWindow* gone) { --gone->users; });
}

std::vector<const char*> surfaceExtensions() {
    return {VK_KHR_SURFACE_EXTENSION_NAME, VK_EXT_HEADLESS_SURFACE_EXTENSION_NAME};
}

doppel::Result<VkSurfaceKHR> makeSurface(VkInstance instance, ANativeWindow* window) {
    const auto vkCreateHeadlessSurface =
        reinterpret_cast<PFN_vkCreateHeadlessSurfaceEXT>(vkGetInstanceProcAddr(instance, "vkCreateHeadlessSurfaceEXT"));
    const VkHeadlessSurfaceCreateInfoEXT info{VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT};
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    dplTestNextWindow(window);
    DPL_VK(vkCreateHeadlessSurface(instance, &info, nullptr, &surface));
    return surface;
}

void sendLogToSystem() {}  // stderr, as without it

}  // namespace dpl::android

// ── the native methods of FakeWindow.java ───────────────────────────────────────────────────────────────────────────────────────

namespace {

ANativeWindow& windowOf(jlong number) {
    return *reinterpret_cast<ANativeWindow*>(number);
}

}  // namespace

extern "C" {

JNIEXPORT jlong JNICALL Java_org_doppel_FakeWindow_make(JNIEnv*, jclass, jint width, jint height) {
    auto* window = new ANativeWindow;
    window->width = uint32_t(width), window->height = uint32_t(height);
    return reinterpret_cast<jlong>(window);
}

JNIEXPORT void JNICALL Java_org_doppel_FakeWindow_destroy(JNIEnv*, jclass, jlong number) {
    delete &windowOf(number);
}

JNIEXPORT void JNICALL Java_org_doppel_FakeWindow_set(JNIEnv* env, jclass, jlong number, jstring name, jint value) {
    const char* text = env->GetStringUTFChars(name, nullptr);
    const std::string key = text;
    env->ReleaseStringUTFChars(name, text);
    if (key == "nextSubmit") return dplTestNextSubmit(VkResult(value));
    ANativeWindow& window = windowOf(number);
    std::lock_guard lock(window.mutex);
    if (key == "width") window.width = uint32_t(value);
    if (key == "height") window.height = uint32_t(value);
    if (key == "transform") window.transform = VkSurfaceTransformFlagBitsKHR(value);
    if (key == "format") window.format = VkFormat(value);
    if (key == "nextAcquire") window.nextAcquire = VkResult(value);
    if (key == "nextPresent") window.nextPresent = VkResult(value);
    if (key == "nextSwapchain") window.nextSwapchain = VkResult(value);
}

/** Users, surfaces, swapchains, pictures shown, width and height of the last one, calls that Vulkan forbids. */
JNIEXPORT void JNICALL Java_org_doppel_FakeWindow_state(JNIEnv* env, jclass, jlong number, jlongArray out) {
    ANativeWindow& window = windowOf(number);
    std::lock_guard lock(window.mutex);
    const jlong values[] = {window.users,
                            window.surfaces,
                            window.swapchains,
                            jlong(window.shownCount),
                            jlong(window.shownWidth),
                            jlong(window.shownHeight),
                            jlong(window.wrong)};
    env->SetLongArrayRegion(out, 0, 7, values);
}

JNIEXPORT jbyteArray JNICALL Java_org_doppel_FakeWindow_shown(JNIEnv* env, jclass, jlong number) {
    ANativeWindow& window = windowOf(number);
    std::lock_guard lock(window.mutex);
    jbyteArray pixels = env->NewByteArray(jsize(window.shown.size()));
    if (pixels) env->SetByteArrayRegion(pixels, 0, jsize(window.shown.size()), reinterpret_cast<const jbyte*>(window.shown.data()));
    return pixels;
}
}
