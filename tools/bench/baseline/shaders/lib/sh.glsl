// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics in the order and sign of sdk/math/sh.h. `d` is a unit vector from the eye to the splat, rest frame; `light` multiplies the colour before it is clamped.
// Coefficients are read through dplSh(k), which the includer defines.
vec3 dplShColour(vec3 d, uint degree, uint base, float light) {
    vec3 c = vec3(0.5) + 0.28209479177387814 * dplSh(base, 0u);
    if (degree >= 1u) {
        const float c1 = 0.4886025119029199;
        c += -c1 * d.y * dplSh(base, 1u) + c1 * d.z * dplSh(base, 2u) - c1 * d.x * dplSh(base, 3u);
    }
    float xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z, xy = d.x * d.y, yz = d.y * d.z, xz = d.x * d.z;
    if (degree >= 2u) {
        c += 1.0925484305920792 * xy * dplSh(base, 4u);
        c += -1.0925484305920792 * yz * dplSh(base, 5u);
        c += 0.31539156525252005 * (2.0 * zz - xx - yy) * dplSh(base, 6u);
        c += -1.0925484305920792 * xz * dplSh(base, 7u);
        c += 0.5462742152960396 * (xx - yy) * dplSh(base, 8u);
    }
    if (degree >= 3u) {
        c += -0.5900435899266435 * d.y * (3.0 * xx - yy) * dplSh(base, 9u);
        c += 2.890611442640554 * xy * d.z * dplSh(base, 10u);
        c += -0.4570457994644658 * d.y * (4.0 * zz - xx - yy) * dplSh(base, 11u);
        c += 0.3731763325901154 * d.z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * dplSh(base, 12u);
        c += -0.4570457994644658 * d.x * (4.0 * zz - xx - yy) * dplSh(base, 13u);
        c += 1.445305721320277 * d.z * (xx - yy) * dplSh(base, 14u);
        c += -0.5900435899266435 * d.x * (xx - 3.0 * yy) * dplSh(base, 15u);
    }
    return clamp(c * light, vec3(0.0), vec3(1.0));
}
