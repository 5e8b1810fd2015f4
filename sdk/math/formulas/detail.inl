// SPDX-License-Identifier: Apache-2.0
// Level of detail of a group of splats (docs/reference/level-of-detail.md). At a share of 1 weights and growth are exactly 1.

/** The share of a group's splats that is kept whole: at least one splat. wanted: splats wanted for each that is there. */
DPL_FN real keptShare(real wanted) {
    return clamp(wanted, real(1.0 / kDetailGroup), real(1));
}

/** What is left of the opacity of the splat of a rank. */
DPL_FN real detailWeight(real share, uint rank) {
    real kept = share * real(kDetailGroup);
    real weight = clamp((kept * real(1.0 + kDetailFade) - (real(rank) + real(0.5))) / (kept * real(kDetailFade)), real(0), real(1));
    return choose(share >= real(1), real(1), weight);
}

/** Factor of the standard deviations of the kept splats that keeps enough area covered; gain, enough: of SplatGroup. */
DPL_FN real detailGrowth(real share, real gain, real enough) {
    return choose(share >= real(1), real(1), sqrt(max(real(1), enough * pow(share, -gain))));
}

/** Number within its group of the splat of a rank: bits in reverse, so that every prefix of the ranks is spread evenly over
 *  neighbours (van der Corput). A group with fewer than kDetailGroup splats lacks some ranks. */
DPL_FN uint placeOfRank(uint rank) {
    uint place = 0u;
    for (uint bit = 0u; bit < 7u; ++bit) place = (place << 1) | ((rank >> bit) & 1u);
    return place;
}

/** Size of a view's pixel, m, where a box comes nearest to the view: dot(axis, point) + offsetM is the size at a point. */
DPL_FN real nearestPixelM(real3 axis, real offsetM, real3 middle, real3 halfSize) {
    return dot(axis, middle) + offsetM - dot(abs(axis), halfSize);
}
