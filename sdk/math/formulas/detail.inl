// SPDX-License-Identifier: Apache-2.0
// Level of detail of a group of splats (docs/reference/level-of-detail.md). At a share of 1 weights and growth are exactly 1.

/** Share of a group's splats that keep their full opacity, at least one splat. wanted: wanted splats over those that are there. */
DPL_FN real keptShare(real wanted) {
    return clamp(wanted, real(1.0 / kDetailGroup), real(1));
}

/** Opacity factor of the splat with this rank: 1 for kept ranks, then falling in a line to 0 over half as many ranks (kDetailFade). */
DPL_FN real detailWeight(real share, uint rank) {
    real kept = share * real(kDetailGroup);
    real weight = clamp((kept * real(1.0 + kDetailFade) - (real(rank) + real(0.5))) / (kept * real(kDetailFade)), real(0), real(1));
    return choose(share >= real(1), real(1), weight);
}

/** Factor of the standard deviations of the kept splats, so that they still cover enough area. gain, enough: of SplatGroup. */
DPL_FN real detailGrowth(real share, real gain, real enough) {
    return choose(share >= real(1), real(1), sqrt(max(real(1), enough * pow(share, -gain))));
}

/** Index within its group of the splat with this rank: the 7 bits of the rank in reverse (van der Corput). The first n ranks are therefore
 *  spread evenly over the group, for every n. A group with fewer than kDetailGroup splats lacks the ranks whose index is too large. */
DPL_FN uint placeOfRank(uint rank) {
    uint place = 0u;
    for (uint bit = 0u; bit < 7u; ++bit) place = (place << 1) | ((rank >> bit) & 1u);
    return place;
}

/** Smallest size of a view's pixel, m, over a box. The size at a point is dot(axis, point) + offsetM. */
DPL_FN real nearestPixelM(real3 axis, real offsetM, real3 middle, real3 halfSize) {
    return dot(axis, middle) + offsetM - dot(abs(axis), halfSize);
}
