// SPDX-License-Identifier: Apache-2.0
// Colour from spherical harmonics (sdk/math/formulas/sh.inl). The includer includes lib/sh_degree.glsl and defines dplSh(base, k), which
// reads coefficient k.
#include "shaders/lib/formulas.glsl"
#include "sdk/math/formulas/sh.inl"

/** (0.5 + Σ basis·sh)·light, clamped to [0,1]. d: unit direction from the eye to the splat, rest frame. */
vec3 dplShColour(vec3 d, uint base, float light) {
    vec3 c = vec3(0.5) + kShC0 * dplSh(base, 0u);
    if (kShDegree >= 1u) {
        ShBand1 b = shBand1(d);
        c += b.b1 * dplSh(base, 1u) + b.b2 * dplSh(base, 2u) + b.b3 * dplSh(base, 3u);
    }
    if (kShDegree >= 2u) {
        ShBand2 b = shBand2(d);
        c += b.b4 * dplSh(base, 4u) + b.b5 * dplSh(base, 5u) + b.b6 * dplSh(base, 6u) + b.b7 * dplSh(base, 7u) + b.b8 * dplSh(base, 8u);
    }
    if (kShDegree >= 3u) {
        ShBand3 b = shBand3(d);
        c += b.b9 * dplSh(base, 9u) + b.b10 * dplSh(base, 10u) + b.b11 * dplSh(base, 11u) + b.b12 * dplSh(base, 12u);
        c += b.b13 * dplSh(base, 13u) + b.b14 * dplSh(base, 14u) + b.b15 * dplSh(base, 15u);
    }
    return clamp(c * light, vec3(0.0), vec3(1.0));
}
