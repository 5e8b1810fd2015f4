// SPDX-License-Identifier: Apache-2.0
// Linear light of display-referred values from 0 to 1, as linearFromSrgb in sdk/math/srgb.h.
vec3 dplLinearFromSrgb(vec3 srgb) {
    return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), srgb));
}
