// SPDX-License-Identifier: Apache-2.0
// Native methods of drawing into a window.
#include <map>
#include <memory>
#include <mutex>

#include "platform/android/native/jni_camera.h"
#include "platform/android/native/jni_help.h"
#include "platform/android/native/jni_platform.h"
#include "platform/android/native/surface_renderer.h"

namespace dpl::android {
namespace {

/** Views by number. Numbers are never used twice, so the use of a view that was closed is detected. A call that is running keeps its view.
 */
class Views {
public:
    jlong add(std::shared_ptr<SurfaceRenderer> view) {
        std::lock_guard lock(mutex_);
        all_[++last_] = std::move(view);
        return last_;
    }
    std::shared_ptr<SurfaceRenderer> take(jlong number) {
        std::lock_guard lock(mutex_);
        const auto found = all_.find(number);
        if (found == all_.end()) return nullptr;
        auto view = std::move(found->second);
        all_.erase(found);
        return view;
    }
    /** Nothing, and an exception: there is no such view. */
    std::shared_ptr<SurfaceRenderer> find(JNIEnv* env, jlong number) {
        std::lock_guard lock(mutex_);
        const auto found = all_.find(number);
        if (found != all_.end()) return found->second;
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "there is no such view; it was closed, or never made");
        return nullptr;
    }

private:
    std::mutex mutex_;
    std::map<jlong, std::shared_ptr<SurfaceRenderer>> all_;
    jlong last_ = 0;
};

Views& views() {
    static Views all;
    return all;
}

jlong createView(JNIEnv* env, jclass, jint fill, jstring cacheFolder, jboolean validation) {
    const std::string folder = toUtf8(env, cacheFolder);
    DplContextInfo info{};
    info.structSize = sizeof info;
    info.fill = DplFill(fill);
    info.cacheFolder = cacheFolder ? folder.c_str() : nullptr;
    auto made = SurfaceRenderer::create(&info, validation);
    if (made) return views().add(std::move(*made));
    throwDoppel(env, made.error().code, made.error().message);
    return 0;
}

void destroyView(JNIEnv* env, jclass, jlong view) {
    if (view != 0 && !views().take(view))
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "there is no such view; it was closed, or never made");
}

jlong viewContext(JNIEnv* env, jclass, jlong view) {
    const auto found = views().find(env, view);
    return found ? numberOf(found->context()) : 0;
}

/** surface: an android.view.Surface, or null for none. */
void setWindow(JNIEnv* env, jclass, jlong view, jobject surface, jint width, jint height) {
    const auto found = views().find(env, view);
    if (!found) return;
    if (width < 0 || height < 0) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "the size of a window is not negative");
    Window window = surface ? windowOf(env, surface) : Window();
    if (surface && !window && !env->ExceptionCheck())
        return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "the surface has been released; wait for surfaceCreated");
    if (!env->ExceptionCheck()) found->setWindow(std::move(window), {uint32_t(width), uint32_t(height)});
}

jint drawView(JNIEnv* env, jclass, jlong view, jlongArray avatars, jfloatArray camera, jobject sceneDepth, jfloat red, jfloat green,
              jfloat blue, jboolean shadows) {
    const auto found = views().find(env, view);
    if (!found) return 0;
    std::optional<DplCamera> seen = cameraOf(env, camera);
    if (!seen || !addSceneDepth(env, sceneDepth, *seen)) return 0;
    const std::vector<DplAvatar> handles = avatarsOf(env, avatars);
    const auto drawn = found->draw({handles, *seen, {red, green, blue}, shadows == JNI_TRUE});
    if (drawn) return jint(*drawn);
    throwDoppel(env, drawn.error().code, drawn.error().message);
    return 0;
}

/** What the validation layer said. */
jobjectArray viewComplaints(JNIEnv* env, jclass, jlong view) {
    const auto found = views().find(env, view);
    return found ? textsOf(env, found->complaints()) : nullptr;
}

}  // namespace

const std::vector<JNINativeMethod> kViewMethods = {
    method("createView", "(ILjava/lang/String;Z)J", createView),
    method("destroyView", "(J)V", destroyView),
    method("viewContext", "(J)J", viewContext),
    method("setWindow", "(JLjava/lang/Object;II)V", setWindow),
    method("drawView", "(J[J[FLjava/nio/FloatBuffer;FFFZ)I", drawView),
    method("viewComplaints", "(J)[Ljava/lang/String;", viewComplaints),
};

}  // namespace dpl::android
