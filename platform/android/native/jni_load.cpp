// SPDX-License-Identifier: Apache-2.0
// Native methods of loads in the background, and the entry point of the library.
#include <algorithm>

#include "platform/android/native/jni_help.h"
#include "platform/android/native/jni_platform.h"

namespace dpl::android {
namespace {

/** The buffer stays reachable, and a mapped file mapped, until the library has read it. */
jlong startLoad(JNIEnv* env, jclass, jlong context, jobject buffer, jlong offset, jlong size) {
    const auto bytes = bytesOf(env, buffer, offset, size);
    if (!bytes) return 0;
    auto* kept = new GlobalRef(env, buffer);
    DplLoadInfo info{};
    info.structSize = sizeof info;
    info.data = bytes->data, info.size = bytes->size;
    info.release = [](void* user) { delete static_cast<GlobalRef*>(user); };
    info.user = kept;
    DplLoad load = nullptr;
    if (check(env, dplStartLoad(handleOf<DplContext>(context), &info, &load))) return numberOf(load);
    delete kept;
    return 0;
}

/** status: DplLoadState and progress. */
void loadStatus(JNIEnv* env, jclass, jlong load, jfloatArray out) {
    DplLoadStatus status{};
    status.structSize = sizeof status;
    if (check(env, dplGetLoadStatus(handleOf<DplLoad>(load), &status))) write(env, out, {float(status.state), status.progress});
}

jlong finishLoad(JNIEnv* env, jclass, jlong load) {
    DplAvatar avatar = nullptr;
    return check(env, dplFinishLoad(handleOf<DplLoad>(load), &avatar)) ? numberOf(avatar) : 0;
}

void cancelLoad(JNIEnv* env, jclass, jlong load) {
    check(env, dplCancelLoad(handleOf<DplLoad>(load)));
}

}  // namespace

const std::vector<JNINativeMethod> kLoadMethods = {
    method("startLoad", "(JLjava/nio/ByteBuffer;JJ)J", startLoad),
    method("loadStatus", "(J[F)V", loadStatus),
    method("finishLoad", "(J)J", finishLoad),
    method("cancelLoad", "(J)V", cancelLoad),
};

}  // namespace dpl::android

extern "C" JNIEXPORT jint JNICALL JNI_OnLoad(JavaVM* vm, void*) {
    using namespace dpl::android;
    void* found = nullptr;
    if (vm->GetEnv(&found, JNI_VERSION_1_6) != JNI_OK) return JNI_ERR;
    auto* env = static_cast<JNIEnv*>(found);
    if (!findClasses(env, vm)) return JNI_ERR;
    jclass natives = env->FindClass("org/doppel/Native");
    if (!natives) return JNI_ERR;
    const auto registered = [&](const std::vector<JNINativeMethod>& methods) {
        return env->RegisterNatives(natives, methods.data(), jint(methods.size())) == JNI_OK;
    };
    const bool all = registered(kContextMethods) && registered(kAvatarMethods) && registered(kLoadMethods) && registered(kTrackerMethods) &&
                     registered(kViewMethods);
    env->DeleteLocalRef(natives);
    if (!all) return JNI_ERR;
    sendLogToSystem();
    return JNI_VERSION_1_6;
}
