// Level of detail: sdk/math/detail.h line by line. Behind lib/codes.glsl.
struct SplatShare {
    uint within;     // its number within the half-chunk
    float weight;    // of its opacity; 0: not drawn
    float growth;    // of its scales
};

/** Which splat of the half-chunk a lane works on: neighbours in order when all are drawn, else its number is a rank, so that whole subgroups at the end have nothing to do. */
SplatShare dplShareOf(uint group, uint rank, float perM2) {
    SplatShare s;
    s.within = rank;
    s.weight = s.growth = 1.0;
    if (perM2 <= 0.0) return s;
    uint at = push.firstGroupDetail + 3u * group;
    float areaM2 = uintBitsToFloat(DPL_WORD(codes, at)), gain = uintBitsToFloat(DPL_WORD(codes, at + 1u)), enough = uintBitsToFloat(DPL_WORD(codes, at + 2u));
    float share = clamp(perM2 * areaM2, 1.0 / float(kSplatGroup), 1.0);
    if (share >= 1.0) return s;
    float whole = share * float(kSplatGroup);
    s.weight = clamp((whole * (1.0 + kGpuDetailFade) - (float(rank) + 0.5)) / (whole * kGpuDetailFade), 0.0, 1.0);
    s.growth = sqrt(max(1.0, enough * pow(share, -gain)));
    s.within = bitfieldReverse(rank) >> 25u;  // seven bits: kSplatGroup
    return s;
}
