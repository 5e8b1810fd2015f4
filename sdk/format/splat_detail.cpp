#include "sdk/format/splat_detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sdk/math/detail.h"

namespace dpl {

static_assert(kSplatChunkSize == 2 * kSplatGroupSize);

void measureGroups(const MeshData& mesh, CodedSplats& s) {
    std::vector<uint32_t> onTriangle(mesh.triangles.size(), 0);
    for (const SplatChunk& c : s.chunks)
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) ++onTriangle[s.parents[c.firstParent + s.parent[i]]];
    std::vector<float> areaM2(mesh.triangles.size());   // of a splat on it
    for (size_t k = 0; k < areaM2.size(); ++k) {
        const Triangle& t = mesh.triangles[k];
        const Vec3f& a = mesh.restPositions[t.x];
        areaM2[k] = 0.5f * glm::length(glm::cross(mesh.restPositions[t.y] - a, mesh.restPositions[t.z] - a)) / float(std::max(1u, onTriangle[k]));
    }
    constexpr float kAt = 0.25f;                         // where the gain is measured
    std::array<float, kSplatGroupSize> weightAt;         // of a place, at that share
    for (uint32_t rank = 0; rank < kSplatGroupSize; ++rank) weightAt[placeOfRank(rank)] = detailWeight(kAt, rank);
    s.groups.assign(2 * s.chunks.size(), {});
    for (size_t g = 0; g < s.groups.size(); ++g) {
        const SplatChunk& c = s.chunks[g / 2];
        const uint32_t begin = c.firstSplat + std::min<uint32_t>(c.splatCount, g % 2 * kSplatGroupSize), count = std::min(kSplatGroupSize, c.firstSplat + c.splatCount - begin);
        // Areas of splats are evenly spaced in the logarithm by the sum of the codes.
        const float step = std::log(c.scaleMaxM / c.scaleMinM) / float(kScaleCodes);
        std::array<float, 64> coarse, fine;
        for (uint32_t k = 0; k < 64; ++k) coarse[k] = std::exp(step * 64 * float(k)), fine[k] = std::exp(step * float(k));
        double area = 0, all = 0, some = 0;              // covered: in units of the smallest splat's
        for (uint32_t k = 0; k < count; ++k) {
            const uint32_t size = s.size[begin + k], code = (size & 2047) + (size >> 11 & 2047);
            const float covered = float(size >> 22 & 255) * coarse[code >> 6] * fine[code & 63];
            area += double(areaM2[s.parents[c.firstParent + s.parent[begin + k]]]), all += double(covered), some += double(covered * weightAt[k]);
        }
        if (!(all > 0 && area > 0) || !std::isfinite(area)) continue;   // nothing that could be seen
        SplatGroup& group = s.groups[g];
        group.areaM2 = float(area / count);
        group.gain = float(std::clamp(std::log(some / all) / std::log(double(kAt)), 0.0, 1.0));
        // A flat splat covers 2π σ₁ σ₂ α; what n of them over an area leave free of it is e^−cover.
        const double cover = 2 * std::numbers::pi * all / 255 * double(c.scaleMinM) * double(c.scaleMinM) / area;
        group.enough = float(std::clamp(-std::log(std::exp(-cover) + kDetailThrough) / cover, 0.0, 1.0));
    }
}

}  // namespace dpl
