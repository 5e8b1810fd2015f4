// SPDX-License-Identifier: Apache-2.0
// Decodes splats as the file stores them (sdk/format/coded_splats.h), in a workgroup that handles one group. The includer declares the
// buffer `codes` by DPL_WORDS and the push constants as CodesPush `push`, and includes lib/sh_degree.glsl.
#include "shaders/lib/parent_byte.glsl"
uint dplFirstChunkWord;  // offset of the record of its chunk; set it before calling anything else
uint dplChunkWord(uint word) { return DPL_WORD(codes, dplFirstChunkWord + word); }

/** First splat of the group, and how many it has. */
uint dplFirstOf(uint group) { return dplChunkWord(0u) + (group & 1u) * kSplatGroup; }
uint dplCountOf(uint group) { return min(max(dplChunkWord(1u), (group & 1u) * kSplatGroup) - (group & 1u) * kSplatGroup, kSplatGroup); }

float dplChunkFloat(uint word) { return uintBitsToFloat(dplChunkWord(word)); }

/** Triangle that the splat is bound to. */
uint dplParent(uint splat) { return DPL_WORD(codes, push.firstParent + dplChunkWord(kChunkFirstParent) + dplParentByte(splat)) & kParentMask; }

bool dplGated(uint size) { return (size & kGatedBit) != 0u; }
float dplOpacity(uint size) { return float((size >> 22u) & 0xFFu) * (1.0 / 255.0); }
vec2 dplUv(uint place) { return (vec2(float(place & 2047u), float((place >> 11u) & 2047u)) - kUvZeroCode) * (1.0 / kUvCodeSteps); }

/** Standard deviations along both axes, metres. Codes are spaced evenly in the logarithm. */
vec2 dplScale(uint size) {
    float low = log(dplChunkFloat(kChunkScaleMin)), width = log(dplChunkFloat(kChunkScaleMax)) - low;
    vec2 code = vec2(float(size & 2047u), float((size >> 11u) & 2047u));
    return vec2(exp(low + width * code.x * (1.0 / 2047.0)), exp(low + width * code.y * (1.0 / 2047.0)));
}

/** Offset of a splat's SH entry, in words. */
uint dplShEntry(uint splat) {
    uint entry = splat;
    if (push.firstShIndex != 0u) entry = (DPL_WORD(codes, push.firstShIndex + (splat >> 1u)) >> ((splat & 1u) * 16u)) & 0xFFFFu;
    return push.firstSh + entry * push.shWords;
}

// Colour coefficients of one splat: fetched once for all views.
const uint kShBytes = 3u * ((kShDegree + 1u) * (kShDegree + 1u) - 1u), kShWords = max(1u, (kShBytes + 3u) / 4u);
vec3 dplShFirst;
float dplShRange[3];
uint dplShWords[kShWords];

/** bands: also fetches the coefficients above 0. */
void dplFetchSh(uint splat, bool bands) {
    vec3 low = vec3(dplChunkFloat(kChunkDcMin), dplChunkFloat(kChunkDcMin + 1u), dplChunkFloat(kChunkDcMin + 2u));
    vec3 high = vec3(dplChunkFloat(kChunkDcMax), dplChunkFloat(kChunkDcMax + 1u), dplChunkFloat(kChunkDcMax + 2u));
    uint colour = DPL_WORD(codes, push.firstColour + splat);
    dplShFirst = low + (high - low) * vec3(float(colour & 1023u) * (1.0 / 1023.0), float((colour >> 10u) & 2047u) * (1.0 / 2047.0), float(colour >> 21u) * (1.0 / 2047.0));
    if (kShDegree == 0u || !bands) return;
    uint entry = dplShEntry(splat);
    for (uint i = 0u; i < kShWords; ++i) dplShWords[i] = DPL_WORD(codes, entry + i);
    for (uint i = 0u; i < kShDegree; ++i) dplShRange[i] = dplChunkFloat(kChunkShRange + i);
}

float dplShByte(uint at) { return float(int(dplShWords[at >> 2u] << (24u - 8u * (at & 3u))) >> 24); }

/** Coefficient k of the fetched splat. */
vec3 dplShCode(uint k) {
    if (k == 0u) return dplShFirst;
    uint at = 3u * (k - 1u);
    return dplShRange[k < 4u ? 0u : k < 9u ? 1u : 2u] * (1.0 / 127.0) * vec3(dplShByte(at), dplShByte(at + 1u), dplShByte(at + 2u));
}
