// SPDX-License-Identifier: Apache-2.0
// Converts other camera conventions to Doppel's: OpenCV axes, X_view = R X_world + t, world y up.
#pragma once

#include <span>

#include "sdk/math/camera.h"

namespace dpl {

/** Converts a camera whose world has z up and faces −y to Doppel's world (y up, facing +z). The point (x, y, z) becomes (x, z, −y), so R is
 *  multiplied by the inverse of this rotation and t stays. */
void turnZUpWorld(Camerad& camera);
/** The same for a point: (x, z, −y). */
Vec3d turnZUpPoint(const Vec3d& p);

/** Sets rotation and translation from a row-major 4×4 world-from-camera matrix with OpenGL axes (x right, y up, looking along −z), as in
 *  nerfstudio's transforms.json. The upper 3×3 is copied unchecked: call checkCamera afterwards. The last row is ignored. */
void setOpenglPose(Camerad& camera, std::span<const double, 16> worldFromCamera);

/** Sets rotation and translation from COLMAP's view-from-world quaternion (any non-zero length) and translation.
 *  A zero or non-finite quaternion gives a NaN rotation, which checkCamera refuses. */
void setColmapPose(Camerad& camera, std::span<const double, 4> wxyz, const Vec3d& translation);

}  // namespace dpl
