// SPDX-License-Identifier: Apache-2.0
// Level of detail: sdk/math/detail.h line by line.
struct SplatShare {
    uint within;     // its number within the half-chunk
    float weight;    // of its opacity; 0: not drawn
    float growth;    // of its scales
};

/** Which splat of the half-chunk a lane works on: neighbours in order when all are drawn, else its number is a rank, so that whole subgroups at the end have nothing to do.
 *  detail: splats wanted where one of its splats is now; gain; enough. */
SplatShare dplShareOf(uint rank, vec3 detail) {
    SplatShare s;
    s.within = rank;
    s.weight = s.growth = 1.0;
    float share = clamp(detail.x, 1.0 / float(kSplatGroup), 1.0);
    if (share >= 1.0) return s;
    float whole = share * float(kSplatGroup);
    s.weight = clamp((whole * (1.0 + kGpuDetailFade) - (float(rank) + 0.5)) / (whole * kGpuDetailFade), 0.0, 1.0);
    s.growth = sqrt(max(1.0, detail.z * pow(share, -detail.y)));
    s.within = bitfieldReverse(rank) >> 25u;  // seven bits: kSplatGroup
    return s;
}
