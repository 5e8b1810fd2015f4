// SPDX-License-Identifier: Apache-2.0
// Cameras for a display that turns its images. A phone's panel is upright whatever way the phone is held; if the program draws its picture
// turned, nobody has to turn it afterwards. Turning the camera about its own axis costs nothing.
#pragma once

#include <doppel/doppel.h>
#include <vulkan/vulkan_core.h>

#include <vector>

namespace dpl::android {

/** The camera of a picture of another size, with the same field of view to each side. For the frames while a window changes its size. */
inline DplCamera fittedView(DplCamera camera, VkExtent2D size) {
    const float sx = float(size.width) / float(camera.widthPx), sy = float(size.height) / float(camera.heightPx);
    camera.fx *= sx, camera.cx *= sx, camera.fy *= sy, camera.cy *= sy;
    camera.widthPx = size.width, camera.heightPx = size.height;
    return camera;
}

/** Whether images of this transform are as wide as the window is high. */
inline bool isQuarterTurn(VkSurfaceTransformFlagBitsKHR transform) {
    return transform == VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR || transform == VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR;
}

/** The camera whose picture is that of `camera`, turned clockwise as `transform` says. Pixel (u, v) of a picture of w × h moves to
 *  (h - v, u) by a quarter turn. Mirrored transforms, which displays of phones do not have, are not turned. */
inline DplCamera rotatedView(const DplCamera& camera, VkSurfaceTransformFlagBitsKHR transform) {
    int turns = 0;
    if (transform == VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR) turns = 1;
    if (transform == VK_SURFACE_TRANSFORM_ROTATE_180_BIT_KHR) turns = 2;
    if (transform == VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR) turns = 3;
    DplCamera turned = camera;
    for (; turns > 0; --turns) {
        const DplCamera before = turned;
        turned.widthPx = before.heightPx, turned.heightPx = before.widthPx;
        turned.fx = before.fy, turned.fy = before.fx;
        turned.cx = float(before.heightPx) - before.cy, turned.cy = before.cx;
        for (int column = 0; column < 4; ++column) {
            turned.viewFromWorld[column] = -before.viewFromWorld[4 + column];
            turned.viewFromWorld[4 + column] = before.viewFromWorld[column];
        }
    }
    return turned;
}

/** The scene depth of `camera` for the picture of rotatedView(fittedView(camera, upright), transform): each pixel has the depth that the
 *  camera's buffer has at the same place. depths: as large as that picture. */
inline void rotatedDepth(const DplCamera& camera, VkExtent2D upright, VkSurfaceTransformFlagBitsKHR transform, std::vector<float>& depths) {
    const VkExtent2D drawn = isQuarterTurn(transform) ? VkExtent2D{upright.height, upright.width} : upright;
    depths.resize(size_t(drawn.width) * drawn.height);
    const bool backwardsX = transform == VK_SURFACE_TRANSFORM_ROTATE_180_BIT_KHR || transform == VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR;
    const bool backwardsY = transform == VK_SURFACE_TRANSFORM_ROTATE_180_BIT_KHR || transform == VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR;
    for (uint32_t y = 0; y < drawn.height; ++y)
        for (uint32_t x = 0; x < drawn.width; ++x) {
            uint32_t u = isQuarterTurn(transform) ? y : x, v = isQuarterTurn(transform) ? x : y;
            if (backwardsX) u = upright.width - 1 - u;
            if (backwardsY) v = upright.height - 1 - v;
            const size_t column = size_t(u) * camera.widthPx / upright.width, row = size_t(v) * camera.heightPx / upright.height;
            depths[size_t(y) * drawn.width + x] = camera.sceneDepthM[row * camera.widthPx + column];
        }
}

}  // namespace dpl::android
