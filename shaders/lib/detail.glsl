// SPDX-License-Identifier: Apache-2.0
// Level of detail: which splat of a group a lane handles, and with what weight.
#include "shaders/lib/formulas.glsl"
#include "sdk/math/formulas/detail.inl"

struct SplatShare {
    uint within;   // number of the splat within its group
    float weight;  // factor of the opacity; 0: not drawn
    float growth;  // factor of the scales
};

/** With all splats drawn, lanes take neighbours in order. Otherwise the lane number is a rank, so that the lanes without work are
 *  the last ones and whole subgroups idle. detail: share of the splats that is wanted, gain, enough. */
SplatShare dplShareOf(uint rank, vec3 detail) {
    SplatShare s;
    s.within = rank;
    s.weight = s.growth = 1.0;
    float share = keptShare(detail.x);
    if (share >= 1.0) return s;
    s.weight = detailWeight(share, rank);
    s.growth = detailGrowth(share, detail.y, detail.z);
    s.within = placeOfRank(rank);
    return s;
}
