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

/** Values are checked by the library. */
DplCamera readCamera(std::span<const float, kCameraFloats> values) {
    const auto side = [](float px) { return px >= 1 && px <= float(DPL_MAX_IMAGE_SIDE_PX) ? uint32_t(px) : 0u; };  // NaN: 0, refused
    DplCamera view{};
    view.structSize = sizeof view;
    view.widthPx = side(values[0]), view.heightPx = side(values[1]);
    view.fx = values[2], view.fy = values[3], view.cx = values[4], view.cy = values[5];
    std::copy(values.begin() + 6, values.end(), view.viewFromWorld);
    return view;
}

/** cameras: one after the other. The arrays of buffers have an element for each camera, or none at all where nothing is wanted of it. */
void render(JNIEnv* env, jclass, jlong context, jlongArray avatars, jfloatArray cameras, jobjectArray sceneDepths, jobjectArray rgbas,
            jobjectArray depths) {
    const std::vector<float> numbers = floatsOf(env, cameras);
    const size_t count = numbers.size() / kCameraFloats;
    if (count < 1 || count > DPL_MAX_VIEWS || numbers.size() % kCameraFloats != 0)
        return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT,
                           "one or two cameras of " + std::to_string(kCameraFloats) + " numbers are drawn at a time");
    for (jobjectArray buffers : {sceneDepths, rgbas, depths})
        if (buffers && size_t(env->GetArrayLength(buffers)) != count)
            return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, std::to_string(count) + " cameras need as many buffers");
    const auto element = [&](jobjectArray buffers, size_t i) { return buffers ? env->GetObjectArrayElement(buffers, jsize(i)) : nullptr; };
    DplCamera views[DPL_MAX_VIEWS];
    DplImage images[DPL_MAX_VIEWS]{};
    for (size_t i = 0; i < count; ++i) {
        views[i] = readCamera(std::span(numbers).subspan(kCameraFloats * i).first<kCameraFloats>());
        if (!addSceneDepth(env, element(sceneDepths, i), views[i])) return;
        images[i].structSize = sizeof images[i];
        if (rgbas) {
            jobject rgba = element(rgbas, i);
            const auto pixels = bytesOf(env, rgba, 0, rgba ? env->GetDirectBufferCapacity(rgba) : 0);
            if (!pixels) return;
            images[i].rgba = pixels->data, images[i].rgbaBytes = pixels->size;
        }
        if (depths) {
            const auto depth = floatsIn(env, element(depths, i));
            if (!depth) return;
            images[i].depthM = depth->data(), images[i].depthCount = depth->size();
        }
    }
    const std::vector<DplAvatar> handles = avatarsOf(env, avatars);
    check(env, dplRenderTogether(handleOf<DplContext>(context), handles.data(), uint32_t(handles.size()), views, uint32_t(count), images));
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
    return readCamera(std::span<const float, kCameraFloats>(values));
}

bool addSceneDepth(JNIEnv* env, jobject depth, DplCamera& camera) {
    if (!depth) return true;
    const auto floats = floatsIn(env, depth);
    if (!floats) return false;
    camera.sceneDepthM = floats->data(), camera.sceneDepthCount = floats->size();
    return true;
}

const std::vector<JNINativeMethod> kContextMethods = {
    method("version", "()I", version),
    method("createContext", "(IIILjava/lang/String;)J", createContext),
    method("destroyContext", "(J)V", destroyContext),
    method("rendererName", "(J)Ljava/lang/String;", rendererName),
    method("setDetail", "(JFI)V", setDetail),
    method("setFrameBudget", "(JD)V", setFrameBudget),
    method("setMemoryLimit", "(JJ)V", setMemoryLimit),
    method("render", "(J[J[F[Ljava/nio/FloatBuffer;[Ljava/nio/ByteBuffer;[Ljava/nio/FloatBuffer;)V", render),
};

}  // namespace dpl::android
