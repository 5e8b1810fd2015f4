// SPDX-License-Identifier: Apache-2.0
// Turns other people's camera conventions into Doppel's: OpenCV axes, X_view = R X_world + t, world y up.
#pragma once

#include <span>

#include "sdk/math/camera.h"

namespace dpl {

/** Turns a world that is z-up and faces −y into Doppel's (y up, faces +z): P = (x, z, −y), so R ← R·Cᵀ and t stays. */
void turnZUpWorld(Camerad& camera);
Vec3d turnZUpPoint(const Vec3d& p);

/** Sets rotation and translation from a row-major 4×4 world-from-camera matrix with OpenGL axes (x right, y up, looking along −z), as in
 *  nerfstudio's transforms.json. The upper 3×3 is taken as it is: checkCamera judges it. The last row is ignored. */
void setOpenglPose(Camerad& camera, std::span<const double, 16> worldFromCamera);

/** Sets rotation and translation from COLMAP's view-from-world quaternion (any non-zero length) and translation.
 *  A zero or non-finite quaternion gives a NaN rotation, which checkCamera refuses. */
void setColmapPose(Camerad& camera, std::span<const double, 4> wxyz, const Vec3d& translation);

}  // namespace dpl
