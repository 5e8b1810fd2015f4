// SPDX-License-Identifier: Apache-2.0
// Native methods of contexts, and of drawing without a window.
#include "platform/android/native/jni_camera.h"
#include "platform/android/native/jni_help.h"

namespace dpl::android {
namespace {

jint version(JNIEnv*, jclass) {
    return jint(dplGetVersion());
}

jlong createContext(JNIEnv* env, jclass, jint renderer, jint threads, jint fill, jstring cacheFolder) {
    const std::string folder = toUtf8(env, cacheFolder);
    DplContextInfo info{};
    info.structSize = sizeof info;
    info.renderer = DplRenderer(renderer), info.fill = DplFill(fill);
    info.threadCount = uint32_t(threads);
    info.cacheFolder = cacheFolder ? folder.c_str() : nullptr;
    DplContext context = nullptr;
    return check(env, dplCreateContext(&info, &context)) ? numberOf(context) : 0;
}

void destroyContext(JNIEnv* env, jclass, jlong context) {
    check(env, dplDestroyContext(handleOf<DplContext>(context)));
}

jstring rendererName(JNIEnv* env, jclass, jlong context) {
    const char* name = nullptr;
    return check(env, dplGetRendererName(handleOf<DplContext>(context), &name)) ? toJava(env, name) : nullptr;
}

void setDetail(JNIEnv* env, jclass, jlong context, jfloat splatsPerPixel, jint splatBudget) {
    if (splatBudget < 0) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a splat budget is not negative; 0 is no limit");
    const DplDetail detail{sizeof detail, splatsPerPixel, uint32_t(splatBudget)};
    check(env, dplSetDetail(handleOf<DplContext>(context), &detail));
}

void setFrameBudget(JNIEnv* env, jclass, jlong context, jdouble milliseconds) {
    check(env, dplSetFrameBudget(handleOf<DplContext>(context), milliseconds));
}

void setMemoryLimit(JNIEnv* env, jclass, jlong context, jlong bytes) {
    if (bytes < 0) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a memory limit is not negative; 0 is no limit");
    check(env, dplSetMemoryLimit(handleOf<DplContext>(context), uint64_t(bytes)));
}

void render(JNIEnv* env, jclass, jlong context, jlongArray avatars, jfloatArray camera, jobject rgba, jint flags) {
    const std::optional<DplCamera> view = cameraOf(env, camera);
    if (!view) return;
    const auto pixels = bytesOf(env, rgba, 0, rgba ? env->GetDirectBufferCapacity(rgba) : 0);
    if (!pixels) return;
    const std::vector<DplAvatar> handles = avatarsOf(env, avatars);
    DplImage image{};
    image.structSize = sizeof image;
    image.flags = uint32_t(flags);
    image.rgba = pixels->data, image.rgbaBytes = pixels->size;
    check(env, dplRenderTogether(handleOf<DplContext>(context), handles.data(), uint32_t(handles.size()), &*view, 1, &image));
}

}  // namespace

std::vector<DplAvatar> avatarsOf(JNIEnv* env, jlongArray avatars) {
    if (!avatars) return {};
    std::vector<jlong> numbers(size_t(env->GetArrayLength(avatars)));
    env->GetLongArrayRegion(avatars, 0, jsize(numbers.size()), numbers.data());
    std::vector<DplAvatar> handles;
    for (const jlong number : numbers) handles.push_back(handleOf<DplAvatar>(number));
    return handles;
}

std::optional<DplCamera> cameraOf(JNIEnv* env, jfloatArray camera) {
    const std::vector<float> values = floatsOf(env, camera);
    if (values.size() != kCameraFloats) {
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a camera has " + std::to_string(kCameraFloats) + " numbers");
        return std::nullopt;
    }
    const auto side = [](float px) { return px >= 1 && px <= float(DPL_MAX_IMAGE_SIDE_PX) ? uint32_t(px) : 0u; };  // NaN: 0, refused
    DplCamera view{};
    view.structSize = sizeof view;
    view.widthPx = side(values[0]), view.heightPx = side(values[1]);
    view.fx = values[2], view.fy = values[3], view.cx = values[4], view.cy = values[5];
    std::copy(values.begin() + 6, values.end(), view.viewFromWorld);
    return view;
}

const std::vector<JNINativeMethod> kContextMethods = {
    method("version", "()I", version),
    method("createContext", "(IIILjava/lang/String;)J", createContext),
    method("destroyContext", "(J)V", destroyContext),
    method("rendererName", "(J)Ljava/lang/String;", rendererName),
    method("setDetail", "(JFI)V", setDetail),
    method("setFrameBudget", "(JD)V", setFrameBudget),
    method("setMemoryLimit", "(JJ)V", setMemoryLimit),
    method("render", "(J[J[FLjava/nio/ByteBuffer;I)V", render),
};

}  // namespace dpl::android
