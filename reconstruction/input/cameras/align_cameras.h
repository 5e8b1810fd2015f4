// SPDX-License-Identifier: Apache-2.0
// Similarity between two worlds in which the same cameras are known, and how far the cameras then differ (docs/reference/cameras.md).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sdk/math/camera.h"

namespace dpl {

/** X_to = scale · rotation · X_from + translation. */
struct Similarity {
    double scale = 1;
    Mat3d rotation{1};
    Vec3d translation{0};

    Vec3d operator()(const Vec3d& from) const { return scale * (rotation * from) + translation; }
};

/** The camera that sees the moved world as `camera` sees the world before. */
Camerad moved(const Camerad& camera, const Similarity& toFromWorld);

/** The similarity that takes the eyes of `from` to those of `to`, and the directions of their axes. from[i] and to[i] are the same camera;
 *  a camera that fits far worse than the others does not count. The rotation is that of the axes, so eyes on one line suffice. nullopt for
 *  fewer than two cameras, different counts, or eyes that all lie at one place, which leave the scale open. */
std::optional<Similarity> alignCameras(std::span<const Camerad> from, std::span<const Camerad> to);

/** How far a camera is from its truth. */
struct CameraError {
    double eye = 0;          // distance of the eyes, world units
    double rotationRad = 0;  // angle between the two rotations
    double px = 0;           // median distance between the two pictures of the points; −1 without points
};

/** `points` (world) lie where the error in pixels matters, on the subject for example. Points behind either camera do not count. */
CameraError cameraError(const Camerad& camera, const Camerad& truth, std::span<const Vec3d> points);

}  // namespace dpl
