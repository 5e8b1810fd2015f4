// SPDX-License-Identifier: Apache-2.0
// doppel-xr on a headset that runs Android: shows assets/avatar.glb. NativeActivity calls android_main on a thread of its own.
#include <android/asset_manager.h>
#include <android/log.h>
#include <android_native_app_glue.h>

#include <chrono>
#include <thread>

#include "apps/xr/avatar_scene.h"
#include "platform/openxr/android_loader.h"

namespace dpl {
namespace {

using namespace std::chrono_literals;

/** Handles what Android has to say. False: the activity ends. */
bool listen(android_app* app, std::chrono::milliseconds wait) {
    android_poll_source* source = nullptr;
    if (ALooper_pollOnce(int(wait.count()), nullptr, nullptr, reinterpret_cast<void**>(&source)) >= 0 && source)
        source->process(app, source);
    return !app->destroyRequested;
}

/** Asks the user for the body, whose tracking Quest gives only to apps that were allowed it. Sessions that begin before the answer have
 *  hands alone. Other headsets do not know the permission and refuse it. */
void askForBody(JNIEnv* env, jobject activity) {
    jclass type = env->GetObjectClass(activity);
    jmethodID ask = env->GetMethodID(type, "requestPermissions", "([Ljava/lang/String;I)V");
    jclass strings = env->FindClass("java/lang/String");
    jstring name = env->NewStringUTF("com.oculus.permission.BODY_TRACKING");
    jobjectArray names = ask && strings && name ? env->NewObjectArray(1, strings, name) : nullptr;
    if (names) env->CallVoidMethod(activity, ask, names, jint(0));
    env->ExceptionClear();  // the app goes on without
    for (jobject local : {jobject(names), jobject(name), jobject(strings), jobject(type)}) env->DeleteLocalRef(local);
}

/** An asset that is stored uncompressed is mapped; nothing is copied before the library reads it. */
doppel::Result<DplAvatar> loadAsset(android_app* app, DplContext context, const char* name) {
    AAsset* asset = AAssetManager_open(app->activity->assetManager, name, AASSET_MODE_BUFFER);
    if (!asset) return doppel::Error{DPL_ERROR_NOT_FOUND, std::string("the APK has no asset ") + name};
    const void* bytes = AAsset_getBuffer(asset);
    DplAvatar avatar = nullptr;
    const DplResult loaded =
        dplLoadAvatar(context, static_cast<const uint8_t*>(bytes), bytes ? size_t(AAsset_getLength64(asset)) : 0, &avatar);
    AAsset_close(asset);
    if (loaded != DPL_OK) return doppel::lastError(loaded);
    return avatar;
}

doppel::Status play(android_app* app, xr::Runtime& runtime) {
    auto handle = loadAsset(app, runtime.context(), "avatar.glb");
    if (!handle) return handle.error();
    doppel::Avatar avatar(runtime.context(), *handle);
    auto puppet = xr::Puppet::of(avatar);
    if (!puppet) return puppet.error();
    const auto about = avatar.info();
    SceneOptions what;
    if (about && about->clipCount > 0) what.clip = 0;
    AvatarScene scene(runtime, avatar, std::move(*puppet), what);
    xr::Session session(runtime, {.nearM = platform::kRoomNearM});
    bool leaving = false;
    for (auto wait = 0ms;;) {
        if (!listen(app, wait) && !std::exchange(leaving, true)) session.requestExit();
        const auto step = session.frame(scene);
        if (!step) return step.error();
        if (*step == xr::Step::Ended) return {};
        if (*step == xr::Step::Drew) scene.moveByControllers(session);
        wait = *step == xr::Step::Idle || *step == xr::Step::Lost ? 5ms : 0ms;  // xrWaitFrame paces the others
    }
}

doppel::Status run(android_app* app) {
    JavaVM* const vm = app->activity->vm;
    const jobject activity = app->activity->clazz;
    if (doppel::Status ready = xr::initialiseLoader(vm, activity); !ready) return ready;
    const XrInstanceCreateInfoAndroidKHR instance = xr::androidInstance(vm, activity);
    xr::RuntimeOptions options;
    options.instanceExtensions = {XR_KHR_ANDROID_CREATE_INSTANCE_EXTENSION_NAME};
    options.instanceNext = &instance;
    for (;;) {
        auto runtime = xr::Runtime::create(options);
        if (runtime) return play(app, **runtime);
        if (runtime.error().code != DPL_ERROR_NOT_FOUND) return runtime.error();
        if (!listen(app, 300ms)) return {};  // the headset is asleep
    }
}

}  // namespace
}  // namespace dpl

void android_main(android_app* app) {
    JNIEnv* env = nullptr;
    app->activity->vm->AttachCurrentThread(&env, nullptr);
    dpl::askForBody(env, app->activity->clazz);
    if (const doppel::Status done = dpl::run(app); !done)
        __android_log_print(ANDROID_LOG_ERROR, "doppel", "%s", done.error().message.c_str());
    ANativeActivity_finish(app->activity);
    while (dpl::listen(app, std::chrono::milliseconds(100))) {
    }  // until Android has noticed
    app->activity->vm->DetachCurrentThread();
}
