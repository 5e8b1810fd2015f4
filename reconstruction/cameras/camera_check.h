// SPDX-License-Identifier: Apache-2.0
// What a camera must satisfy before a scan is believed: finite, a true rotation, intrinsics that fit the picture.
#pragma once

#include <string_view>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

constexpr uint64_t kMaxImagePixels = 64ull << 20;  // 64 MP: larger pictures are refused before they are decoded

/** Brown's model in the order of OpenCV: x' = x(1 + k1 r² + k2 r⁴) + 2 p1 xy + p2 (r² + 2x²), and the same for y. Unitless. */
struct LensDistortion {
    double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
    bool any() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0; }
};

/** Refuses sizes of zero or above kMaxImagePixels. `where` names the file and the entry, for the message. */
Status checkImageSize(uint64_t widthPx, uint64_t heightPx, std::string_view where);

/** Checks size, focal lengths (finite, > 0, a field of view between 1° and 150°), principal point (inside the picture widened by half its
 *  size) and rotation (orthonormal to 1e-3, det +1); then makes the rotation orthonormal to rounding. `where` names file and frame. */
Status checkCamera(Camerad& camera, std::string_view where);

/** Refuses non-finite coefficients and a lens that folds over inside the picture (not invertible). */
Status checkDistortion(const LensDistortion& lens, const Camerad& camera, std::string_view where);

}  // namespace dpl
