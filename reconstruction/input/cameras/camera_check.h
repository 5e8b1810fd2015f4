// SPDX-License-Identifier: Apache-2.0
// Checks of a scan's cameras: finite numbers, a proper rotation, intrinsics that fit the picture.
#pragma once

#include <string_view>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

/** Brown's model with the coefficients of OpenCV: x' = x(1 + k1 r² + k2 r⁴) + 2 p1 xy + p2 (r² + 2x²), and
 *  y' = y(1 + k1 r² + k2 r⁴) + p1 (r² + 2y²) + 2 p2 xy. Unitless. */
struct LensDistortion {
    double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
    bool any() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0; }
};

/** Checks size, focal lengths (field of view between 1° and 150°, fx and fy within a factor of two), principal point (at most half a
 * picture size outside the picture), translation (finite, at most 1e6) and rotation (orthonormal to 1e-3, determinant +1). Then makes the
 * rotation orthonormal to double precision. `where` starts the message: file and frame. */
Status checkCamera(Camerad& camera, std::string_view where);

/** Refuses non-finite coefficients, |p1| or |p2| above 0.1, and a model that is not invertible inside the picture or stretches it more than
 *  four times there. */
Status checkDistortion(const LensDistortion& lens, const Camerad& camera, std::string_view where);

}  // namespace dpl
