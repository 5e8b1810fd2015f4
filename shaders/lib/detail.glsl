// SPDX-License-Identifier: Apache-2.0
// Level of detail: which splat of a group a lane handles, and with what weight.
#include "shaders/lib/formulas.glsl"
#include "sdk/math/formulas/detail.inl"

struct SplatShare {
    uint within;   // number of the splat within its group
    float weight;  // factor of the opacity; 0: not drawn
    float growth;  // factor of the scales
};

struct WantedDetail {  // of one group
    float share;         // of its splats; 1 or more: all
    float gain, enough;  // of its SplatGroup (sdk/math/detail.h)
};

/** With all splats drawn, lanes take neighbours in order. Otherwise the lane number is a rank, so that the lanes without work are
 *  the last ones and whole subgroups idle. */
SplatShare dplShareOf(uint rank, WantedDetail detail) {
    SplatShare s;
    s.within = rank;
    s.weight = s.growth = 1.0;
    float share = keptShare(detail.share);
    if (share >= 1.0) return s;
    s.weight = detailWeight(share, rank);
    s.growth = detailGrowth(share, detail.gain, detail.enough);
    s.within = placeOfRank(rank);
    return s;
}
