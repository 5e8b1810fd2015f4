// SPDX-License-Identifier: Apache-2.0
/* Aims cameras, and converts what engines and headsets use to what Doppel uses: views and projections to DplCamera, left-handed poses,
 * depth buffers, timestamps. Include it beside doppel.h; C99 and C++. Tables for OpenXR, Unity, Unreal and visionOS:
 * docs/guides/conventions-for-engines.md.
 *
 * A pose here is an orientation (quaternion x, y, z, w) and a position (3 floats, metres) of something in the world, in OpenXR's axes:
 * x right, y up, looks along -z. dplPoseFromAxes makes one of a pose in other axes. Quaternions are normalised by the functions.
 *
 * All functions may be called from any thread, without a context. They compute in double precision. DPL_ERROR_INVALID_ARGUMENT: NULL, a
 * number that is not finite, a zero quaternion, or what a function names. */
#ifndef DOPPEL_DOPPEL_CONVERT_H
#define DOPPEL_DOPPEL_CONVERT_H

#include <doppel/doppel.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A camera at `eye` that looks at `target`, which lands in the middle of the picture.
 *  eye, target: 3 floats, metres, in the world; at most 100 km and any distance between them. up: 3 floats, of any length: the direction
 * that points up in the picture, usually (0, 1, 0), the world's up. To look straight down or up, give a sideways one such as (0, 0, -1).
 *  fovYRad: vertical field of view, radians, above 0 and up to 179.8 degrees. Pixels are square. camera: structSize set; the scene depth
 *  becomes NULL.
 *    const float eye[3] = {0, 1, 3}, target[3] = {0, 1, 0}, up[3] = {0, 1, 0};  // before an avatar at rest, which faces +Z
 *    dplCameraLookAt(eye, target, up, 0.8f, 512, 768, &camera)
 *  DPL_ERROR_INVALID_ARGUMENT: also eye and target in one point, an up that is zero or parallel to the view direction, a size of 0 or above
 *  DPL_MAX_IMAGE_SIDE_PX, and a field of view so small that the focal length exceeds 10 million pixels. */
DPL_EXPERIMENTAL DplResult dplCameraLookAt(const float* eye, const float* target, const float* up, float fovYRad, uint32_t widthPx,
                                           uint32_t heightPx, DplCamera* camera);

/** The camera of a view that is given by four angles, as OpenXR, ARKit and visionOS do. The frustum may be asymmetric and canted.
 *  anglesRad: of the left, right, top and bottom edge from straight ahead, as XrFovf: usually left and bottom are negative. Left must be
 *  below right and bottom below top, all within 89.9 degrees. camera: structSize set; the scene depth becomes NULL.
 *    dplCameraFromAngles(&view.pose.orientation.x, &view.pose.position.x, &view.fov.angleLeft, width, height, &camera)
 *  DPL_ERROR_INVALID_ARGUMENT: also a size of 0 or above DPL_MAX_IMAGE_SIDE_PX. */
DPL_API DplResult dplCameraFromAngles(const float* orientation, const float* position, const float* anglesRad, uint32_t widthPx,
                                      uint32_t heightPx, DplCamera* camera);

/** What the clip space of a projection calls the nearest and the farthest depth. */
typedef enum DplClipDepth {
    DPL_CLIP_DEPTH_ZERO_TO_ONE = 0,      /**< Vulkan, Metal, Direct3D; reversed or not */
    DPL_CLIP_DEPTH_MINUS_ONE_TO_ONE = 1, /**< OpenGL; Unity's Camera.projectionMatrix on every platform */
    DPL_CLIP_DEPTH_FORCE_INT32 = 0x7fffffff
} DplClipDepth;

/** The camera of a view that is given by a projection matrix, and how that matrix stores depth.
 *  projection: 16 floats, column-major, clip = projection · view. View space has x right and y up; the signs in the matrix tell whether it
 *  looks along -z or +z and whether clip y points up (OpenGL, Metal, Direct3D) or down (Vulkan). The picture's top row is the view's top.
 *  depth: two floats, `scale` and `offset` of DplVulkanSceneDepth: stored depth = scale + offset / z. It may be reversed, and the far plane
 *  may be infinite. NULL: not wanted.
 *  DPL_ERROR_INVALID_ARGUMENT: also a projection that is not a perspective one, is skewed, or mirrors x. */
DPL_API DplResult dplCameraFromProjection(const float* orientation, const float* position, const float* projection, DplClipDepth clipDepth,
                                          uint32_t widthPx, uint32_t heightPx, DplCamera* camera, float* depth);

/** How a depth buffer stores depth whose two ends are known: `scale` and `offset` of DplVulkanSceneDepth.
 *  zAtZeroM, zAtOneM: distance along the view axis where 0 and 1 are stored, metres, > 0 and different. Usual: near, far. Reversed: far,
 *  near. One of them may be INFINITY. depth: two floats. */
DPL_API DplResult dplDepthFromPlanes(float zAtZeroM, float zAtOneM, float* depth);

/** Axes and units in which an engine gives poses. */
typedef enum DplAxes {
    DPL_AXES_OPENXR = 0, /**< right-handed, x right, y up, looks along -z, metres. Also ARKit, visionOS, glTF, Godot */
    DPL_AXES_UNITY = 1,  /**< left-handed, x right, y up, looks along +z, metres */
    DPL_AXES_UNREAL = 2, /**< left-handed, x forward, y right, z up, centimetres */
    DPL_AXES_FORCE_INT32 = 0x7fffffff
} DplAxes;

/** A pose in an engine's axes as a pose here. The world is mirrored where the engine is left-handed: (x, y, z) of Unity becomes
 *  (x, y, -z), and (x, y, z) of Unreal becomes (y, z, -x) / 100. Outputs may be the inputs. */
DPL_API DplResult dplPoseFromAxes(DplAxes axes, const float* orientation, const float* position, float* outOrientation, float* outPosition);

/** Seconds from one timestamp in nanoseconds to another, such as two XrTime; negative if `timeNs` is earlier. Keeps nanoseconds for 100
 *  days and never overflows. For the time of a clip, pass the predicted display time and that of the first frame. */
DPL_API double dplSecondsBetween(int64_t startNs, int64_t timeNs);

#ifdef __cplusplus
}
#endif
#endif
