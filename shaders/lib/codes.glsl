// Splats as they lie in the file (sdk/format/coded_splats.h), by a workgroup that works on one half-chunk. The includer declares the buffer by
// DPL_WORDS `codes` and the push constants as CodesPush `push`.
#include "shaders/lib/parent_byte.glsl"
uint dplFirstChunkWord;  // of the record of its chunk; set it before anything else
uint dplChunkWord(uint word) { return DPL_WORD(codes, dplFirstChunkWord + word); }

/** Its first splat, and how many it has. */
uint dplFirstOf(uint group) { return dplChunkWord(0u) + (group & 1u) * kSplatGroup; }
uint dplCountOf(uint group) { return min(max(dplChunkWord(1u), (group & 1u) * kSplatGroup) - (group & 1u) * kSplatGroup, kSplatGroup); }

float dplChunkFloat(uint word) { return uintBitsToFloat(dplChunkWord(word)); }

/** Its triangle. */
uint dplParent(uint splat) { return DPL_WORD(codes, push.firstParent + dplChunkWord(kChunkFirstParent) + dplParentByte(splat)) & kParentMask; }

bool dplGated(uint size) { return (size & kGatedBit) != 0u; }
float dplOpacity(uint size) { return float((size >> 22u) & 0xFFu) * (1.0 / 255.0); }
vec2 dplUv(uint place) { return (vec2(float(place & 2047u), float((place >> 11u) & 2047u)) - kUvZeroCode) * (1.0 / kUvCodeSteps); }

/** Standard deviations of both axes, metres: evenly spaced in the logarithm. */
vec2 dplScale(uint size) {
    float low = log(dplChunkFloat(kChunkScaleMin)), width = log(dplChunkFloat(kChunkScaleMax)) - low;
    vec2 code = vec2(float(size & 2047u), float((size >> 11u) & 2047u));
    return vec2(exp(low + width * code.x * (1.0 / 2047.0)), exp(low + width * code.y * (1.0 / 2047.0)));
}

float dplShByte(uint entry, uint at) { return float(int(DPL_WORD(codes, entry + (at >> 2u)) << (24u - 8u * (at & 3u))) >> 24); }

/** Coefficient k of a splat whose entry begins at a word; 0 comes from its colour word. */
vec3 dplShCode(uint entry, uint colour, uint k) {
    if (k == 0u) {
        vec3 low = vec3(dplChunkFloat(kChunkDcMin), dplChunkFloat(kChunkDcMin + 1u), dplChunkFloat(kChunkDcMin + 2u));
        vec3 high = vec3(dplChunkFloat(kChunkDcMax), dplChunkFloat(kChunkDcMax + 1u), dplChunkFloat(kChunkDcMax + 2u));
        return low + (high - low) * vec3(float(colour & 1023u) * (1.0 / 1023.0), float((colour >> 10u) & 2047u) * (1.0 / 2047.0), float(colour >> 21u) * (1.0 / 2047.0));
    }
    uint at = 3u * (k - 1u);
    float range = dplChunkFloat(kChunkShRange + (k < 4u ? 0u : k < 9u ? 1u : 2u));
    return range * (1.0 / 127.0) * vec3(dplShByte(entry, at), dplShByte(entry, at + 1u), dplShByte(entry, at + 2u));
}

/** Where the SH entry of a splat begins, in words. */
uint dplShEntry(uint splat) {
    uint entry = splat;
    if (push.firstShIndex != 0u) entry = (DPL_WORD(codes, push.firstShIndex + (splat >> 1u)) >> ((splat & 1u) * 16u)) & 0xFFFFu;
    return push.firstSh + entry * push.shWords;
}
