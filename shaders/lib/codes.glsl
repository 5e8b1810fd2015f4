// Splats as they lie in the file (sdk/format/coded_splats.h), read by one kernel or another from one buffer. The includer declares it as `uint codes[]`
// and the push constants as CodesPush `push`. Phase 1 reads the parent byte and the size word; the rest is for splats that a view shows.
struct SplatPlace {
    uint chunk;   // its record, as a word offset
    uint splat;
    bool exists;
};

/** Splat of a lane of half-chunk `group`. */
SplatPlace dplPlaceOf(uint group, uint lane) {
    SplatPlace p;
    p.chunk = (group >> 1u) * kChunkWords;
    uint within = (group & 1u) * kSplatGroup + lane;
    p.splat = codes[p.chunk] + within;
    p.exists = within < codes[p.chunk + 1u];
    return p;
}

float dplChunkFloat(SplatPlace p, uint word) { return uintBitsToFloat(codes[p.chunk + word]); }

/** Its triangle. */
uint dplParent(SplatPlace p) {
    uint byte = (codes[push.firstParentByte + (p.splat >> 2u)] >> ((p.splat & 3u) * 8u)) & 0xFFu;
    return codes[push.firstParent + codes[p.chunk + kChunkFirstParent] + byte];
}

bool dplGated(uint size) { return (size & kGatedBit) != 0u; }
uint dplSize(SplatPlace p) { return codes[push.firstSize + p.splat]; }
float dplOpacity(uint size) { return float((size >> 22u) & 0xFFu) * (1.0 / 255.0); }
vec2 dplUv(uint place) { return (vec2(float(place & 2047u), float((place >> 11u) & 2047u)) - kUvZeroCode) * (1.0 / kUvCodeSteps); }

/** Standard deviations of both axes, metres: evenly spaced in the logarithm. */
vec2 dplScale(SplatPlace p, uint size) {
    float low = log(dplChunkFloat(p, kChunkScaleMin)), width = log(dplChunkFloat(p, kChunkScaleMax)) - low;
    vec2 code = vec2(float(size & 2047u), float((size >> 11u) & 2047u));
    return vec2(exp(low + width * code.x * (1.0 / 2047.0)), exp(low + width * code.y * (1.0 / 2047.0)));
}
