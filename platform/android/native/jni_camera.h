// SPDX-License-Identifier: Apache-2.0
// Cameras and lists of avatars as they cross from Java.
#pragma once

#include <doppel/doppel.h>
#include <jni.h>

#include <optional>
#include <vector>

namespace dpl::android {

/** Of a camera in Java: width, height, fx, fy, cx, cy, and the twelve of DplCamera::viewFromWorld. */
constexpr size_t kCameraFloats = 18;

/** Nothing, and an exception: not that many numbers. Their values are checked by the library. */
std::optional<DplCamera> cameraOf(JNIEnv* env, jfloatArray camera);
/** Gives a camera the depth of the app's scene: a direct FloatBuffer, which must stay reachable while it is used, or null for none. False,
 *  and an exception: no direct buffer. Its size is checked by the library. */
bool addSceneDepth(JNIEnv* env, jobject depth, DplCamera& camera);
std::vector<DplAvatar> avatarsOf(JNIEnv* env, jlongArray avatars);

}  // namespace dpl::android
