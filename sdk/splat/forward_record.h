// SPDX-License-Identifier: Apache-2.0
// What projecting a bound splat computes on the way and its backward pass reads (docs/reference/footprint.md).
#pragma once

#include <cstddef>

namespace dpl {

/** Of one splat in one view. The kernel stores it as eight quads: keep the order. */
template <class T>
struct alignas(64) ForwardRecord {
    T a10, a11, a20, a21;                  // axes in the columns of F: A1 = a10·F0 + a11·F1, A2 = a20·F0 + a21·F1
    T b1X, b1Y, b2X, b2Y;                  // axes on the screen, px
    T slopeX, slopeY;                      // x/z, y/z of the centre in view space
    T clampedX, clampedY;                  // the same, clamped as the Jacobian has them
    T depthM, inverseZ;                    // view z, and 1/z
    T axis1Z, axis2Z;                      // view z of the axes, metres
    T conicA, conicB, conicC, inverseDet;  // Σ'⁻¹ as blending reads it, and 1/det Σ'
    T compensation, nearFade, gate;        // factors of the opacity; gate is 1 for splats that show both faces
    T cosine;                              // cosθ between the triangle's normal and the direction to the eye
    T directionX, directionY, directionZ;  // unit, from the eye to the splat, in the rest frame of its triangle
    T inverseDistance;                     // 1/|eye − centre|, 1/m
    T red, green, blue;                    // colour before brightness and clamp
    T light;                               // brightness
};
static_assert(sizeof(ForwardRecord<float>) == 128 && offsetof(ForwardRecord<float>, light) == 124);

}  // namespace dpl
