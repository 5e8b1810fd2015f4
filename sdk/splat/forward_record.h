// SPDX-License-Identifier: Apache-2.0
// Intermediates of projecting a bound splat, kept for the backward pass (docs/reference/footprint.md).
#pragma once

#include <cstddef>

namespace dpl {

/** One splat in one view. The kernel stores it as eight quads of four floats: keep the order of the members. */
template <class T>
struct alignas(64) ForwardRecord {
    T a10, a11, a20, a21;                  // A1 = a10·F0 + a11·F1, A2 = a20·F0 + a21·F1; metres
    T b1X, b1Y, b2X, b2Y;                  // axes on the screen, px
    T slopeX, slopeY;                      // x/z, y/z of the centre in view space
    T clampedX, clampedY;                  // the same, clamped as in the Jacobian
    T depthM, inverseZ;                    // view z, and 1/z
    T axis1Z, axis2Z;                      // view z of the axes, metres
    T conicA, conicB, conicC, inverseDet;  // Σ'⁻¹ = [A B; B C] in 1/px², and 1/det Σ'
    T compensation, nearFade, gate;        // factors of the opacity; gate includes that of the triangle (TriangleFrame::shown)
    T cosine;                              // cosθ between the triangle's normal and the direction to the eye
    T directionX, directionY, directionZ;  // unit vector from the eye to the splat, turned into the rest frame
    T inverseDistance;                     // 1/|eye − centre|, 1/m
    T red, green, blue;                    // 0.5 + Σ basis·sh, before brightness and clamp
    T light;                               // brightness (docs/reference/correctives.md)
};
static_assert(sizeof(ForwardRecord<float>) == 128 && offsetof(ForwardRecord<float>, light) == 124);

}  // namespace dpl
