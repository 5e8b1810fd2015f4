// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/coded_groups.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

namespace dpl {
namespace {

struct Turn {
    float cosine, sine;
};

/** cos and sin of φ for every code of φ. 8 KB. */
const std::array<Turn, kPhiSteps>& turns() {
    static const std::array<Turn, kPhiSteps> table = [] {
        std::array<Turn, kPhiSteps> t;
        for (uint32_t c = 0; c < kPhiSteps; ++c)
            t[c] = {float(std::cos(c * std::numbers::pi / kPhiSteps)), float(std::sin(c * std::numbers::pi / kPhiSteps))};
        return t;
    }();
    return table;
}

}  // namespace

CodedGroups::CodedGroups(const CodedSplats& splats, uint32_t firstSplat, float shShare)
    : splats_(splats), shDegree_(shShare > 0 ? splats.shDegree : 0), shShare_(shShare) {
    const auto after = std::upper_bound(splats.chunks.begin(), splats.chunks.end(), firstSplat,
                                        [](uint32_t i, const SplatChunk& c) { return i < c.firstSplat; });
    if (after != splats.chunks.begin()) enter(size_t(after - splats.chunks.begin()) - 1);
}

void CodedGroups::enter(size_t chunk) {
    const SplatChunk& c = splats_.chunks[chunk];
    chunk_ = chunk, chunkEnd_ = c.firstSplat + c.splatCount, firstParent_ = c.firstParent;
    const double low = std::log(double(c.scaleMinM)), step = (std::log(double(c.scaleMaxM)) - low) / kScaleCodes;
    for (uint32_t k = 0; k < 32; ++k) coarse_[k] = float(std::exp(low + step * 64 * k));
    for (uint32_t k = 0; k < 64; ++k) fine_[k] = float(std::exp(step * k));
    for (int k = 0; k < 3; ++k) {
        dcMin_[k] = c.dcMin[k], dcStep_[k] = (c.dcMax[k] - c.dcMin[k]) / float(kColourCodes[k]);
        shStep_[k] = c.shRange[k] / 127 * shShare_;
    }
}

void CodedGroups::decode(uint32_t first, float* out) {
    const uint32_t lanes = std::min(kGroupSplats, splats_.count() - first);
    if (lanes < kGroupSplats) std::memset(out, 0, groupFields(true, shDegree_) * kGroupSplats * sizeof(float));
    for (uint32_t lane = 0; lane < lanes; ++lane) decodeOne(first + lane, lane, out);
}

void CodedGroups::decode(std::span<const ChosenSplat> chosen, float* out) {
    using namespace bound_field;
    if (chosen.size() < kGroupSplats) std::memset(out, 0, groupFields(true, shDegree_) * kGroupSplats * sizeof(float));
    for (uint32_t lane = 0; lane < chosen.size(); ++lane) {
        decodeOne(chosen[lane].splat, lane, out);
        out[kOpacity * kGroupSplats + lane] *= chosen[lane].weight;
        for (const uint32_t axis : {kAxis10, kAxis11, kAxis20, kAxis21}) out[axis * kGroupSplats + lane] *= chosen[lane].growth;
    }
}

void CodedGroups::decodeOne(uint32_t i, uint32_t lane, float* out) {
    using namespace bound_field;
    constexpr float kUvStep = float(1 / kUvSteps);
    while (i >= chunkEnd_) enter(chunk_ + 1);  // culling may have skipped whole chunks
    const auto put = [&](uint32_t field, float value) { out[field * kGroupSplats + lane] = value; };
    const uint32_t place = splats_.place[i], size = splats_.size[i], colour = splats_.colour[i];
    const auto scale = [&](uint32_t code) { return coarse_[code >> 6] * fine_[code & 63]; };
    const Turn t = turns()[place >> 22];
    const auto a = Formulas<float>::planeAxes(t.cosine, t.sine, scale(size & 2047), scale(size >> 11 & 2047));
    put(kU, float(int(place & 2047) - kUvZero) * kUvStep), put(kV, float(int(place >> 11 & 2047) - kUvZero) * kUvStep);
    put(kAxis10, a.a10), put(kAxis11, a.a11), put(kAxis20, a.a20), put(kAxis21, a.a21);
    put(kOpacity, float(size >> 22 & 255) * (1.0f / 255));
    put(kSingleFace, float(size >> 30 & 1)), put(kCloth, float(size >> 31));
    put(kTriangle, std::bit_cast<float>(splats_.parents[firstParent_ + splats_.parent[i]]));
    float* sh = out + kSh * kGroupSplats + lane;
    sh[0] = dcMin_[0] + dcStep_[0] * float(colour & 1023);
    sh[kGroupSplats] = dcMin_[1] + dcStep_[1] * float(colour >> 10 & 2047);
    sh[2 * kGroupSplats] = dcMin_[2] + dcStep_[2] * float(colour >> 21);
    if (shDegree_ == 0) return;
    const int8_t* codes = splats_.sh.data() + size_t(splats_.shIndex.empty() ? i : splats_.shIndex[i]) * shEntryBytes(splats_.shDegree) - 3;
    for (uint32_t band = 1; band <= shDegree_; ++band)
        for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) sh[k * kGroupSplats] = float(codes[k]) * shStep_[band - 1];
}

}  // namespace dpl
