// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_chunks.h"

#include <cmath>

namespace dpl {

void setParents(CodedSplats& out, const std::vector<uint32_t>& start) {
    const uint32_t n = out.count();
    out.parent.resize(n);
    uint32_t triangle = 0;
    size_t parents = 0;
    for (size_t t = 0; t + 1 < start.size(); ++t) parents += start[t] != start[t + 1];
    out.parents.reserve(parents + out.chunks.size());
    for (SplatChunk& c : out.chunks) {
        c.firstParent = uint32_t(out.parents.size());
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            while (start[triangle + 1] <= i) ++triangle;
            if (out.parents.size() == c.firstParent || out.parents.back() != triangle) out.parents.push_back(triangle);
            out.parent[i] = uint8_t(out.parents.size() - 1 - c.firstParent);
        }
        c.firstTriangle = out.parents[c.firstParent], c.endTriangle = triangle + 1;
    }
}

std::vector<uint32_t> triangleStarts(const CodedSplats& coded, size_t triangleCount) {
    std::vector<uint32_t> start(triangleCount + 1, 0);
    for (const SplatChunk& c : coded.chunks)
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) ++start[coded.parents[c.firstParent + coded.parent[i]] + 1];
    for (size_t t = 0; t < triangleCount; ++t) start[t + 1] += start[t];
    return start;
}

Status checkRanges(const SplatChunk& c, size_t index) {
    constexpr float kMaxScaleM = 1e3f, kMaxSh = 1e6f;
    const auto ordered = [](float low, float high, float limit) {
        return std::isfinite(low) && std::isfinite(high) && low <= high && std::abs(low) <= limit && std::abs(high) <= limit;
    };
    bool ok = ordered(c.scaleMinM, c.scaleMaxM, kMaxScaleM) && c.scaleMinM >= kMinSplatScaleM;
    for (int k = 0; k < 3; ++k) ok = ok && ordered(c.dcMin[k], c.dcMax[k], kMaxSh) && ordered(0, c.shRange[k], kMaxSh);
    if (!ok) return fail(Code::CorruptData, "chunk {} has a range that is not finite, empty or too large", index);
    return {};
}

}  // namespace dpl
