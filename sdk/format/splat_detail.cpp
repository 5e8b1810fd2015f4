// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_detail.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <numbers>

#include "sdk/math/detail.h"

namespace dpl {

static_assert(kSplatChunkSize == 2 * kSplatGroupSize);

namespace {

constexpr float kAt = 0.25f;  // share of splats at which the gain is measured

/** Detail weight of the splat at each place of a group, at the share kAt. */
std::array<float, kSplatGroupSize> weightsThere() {
    std::array<float, kSplatGroupSize> weight;
    for (uint32_t rank = 0; rank < kSplatGroupSize; ++rank) weight[placeOfRank(rank)] = detailWeight(kAt, rank);
    return weight;
}

/** areaM2: surface of the group. coveredM2: sum of the areas that its splats cover, each 2π σ₁ σ₂ α. someM2: the same sum with the weights
 *  at kAt. With cover = coveredM2 / areaM2, the share e^−cover of the light passes through. */
SplatGroup groupOf(double areaM2, uint32_t count, double coveredM2, double someM2) {
    SplatGroup group;
    if (!(coveredM2 > 0 && areaM2 > 0) || !std::isfinite(areaM2) || !std::isfinite(coveredM2)) return group;  // nothing visible
    const double cover = coveredM2 / areaM2;
    group.areaM2 = float(areaM2 / count);
    group.gain = float(std::clamp(std::log(someM2 / coveredM2) / std::log(double(kAt)), 0.0, 1.0));
    group.enough = float(std::clamp(-std::log(std::exp(-cover) + kDetailThrough) / cover, 0.0, 1.0));
    return group;
}

}  // namespace

void measureGroups(const MeshData& mesh, CodedSplats& s) {
    std::vector<uint32_t> onTriangle(mesh.triangles.size(), 0);
    for (const SplatChunk& c : s.chunks)
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) ++onTriangle[s.parents[c.firstParent + s.parent[i]]];
    std::vector<float> areaM2(mesh.triangles.size());  // of the triangle, per splat on it
    for (size_t k = 0; k < areaM2.size(); ++k) {
        const Triangle& t = mesh.triangles[k];
        const Vec3f& a = mesh.restPositions[t.x];
        areaM2[k] =
            0.5f * glm::length(glm::cross(mesh.restPositions[t.y] - a, mesh.restPositions[t.z] - a)) / float(std::max(1u, onTriangle[k]));
    }
    const std::array<float, kSplatGroupSize> weightAt = weightsThere();
    s.groups.assign(2 * s.chunks.size(), {});
    for (size_t g = 0; g < s.groups.size(); ++g) {
        const SplatChunk& c = s.chunks[g / 2];
        const uint32_t begin = groupRange(s, g).first, count = groupRange(s, g).count();
        // The logarithm of a splat's area is linear in the sum of its two scale codes; two tables of 64 give its exponential.
        const float step = std::log(c.scaleMaxM / c.scaleMinM) / float(kScaleCodes);
        std::array<float, 64> coarse, fine;
        for (uint32_t k = 0; k < 64; ++k) coarse[k] = std::exp(step * 64 * float(k)), fine[k] = std::exp(step * float(k));
        double area = 0, all = 0, some = 0;  // all, some: in units of unitM2
        for (uint32_t k = 0; k < count; ++k) {
            const uint32_t size = s.size[begin + k], code = (size & 2047) + (size >> 11 & 2047);
            const float covered = float(size >> 22 & 255) * coarse[code >> 6] * fine[code & 63];
            area += double(areaM2[s.parents[c.firstParent + s.parent[begin + k]]]), all += double(covered),
                some += double(covered * weightAt[k]);
        }
        const double unitM2 = 2 * std::numbers::pi / 255 * double(c.scaleMinM) * double(c.scaleMinM);
        s.groups[g] = groupOf(area, count, all * unitM2, some * unitM2);
    }
}

std::vector<GeneralGroup> measureGroups(const StaticSplatData& s, std::span<const uint32_t> order) {
    const std::array<float, kSplatGroupSize> weightAt = weightsThere();
    std::vector<GeneralGroup> groups;
    groups.reserve((order.size() + kSplatGroupSize - 1) / kSplatGroupSize);
    for (size_t first = 0; first < order.size(); first += kSplatGroupSize) {
        const std::span<const uint32_t> members = order.subspan(first, std::min<size_t>(kSplatGroupSize, order.size() - first));
        GeneralGroup& group = groups.emplace_back();
        Vec3f low(FLT_MAX), high(-FLT_MAX);
        for (const uint32_t i : members) low = glm::min(low, s.position[i]), high = glm::max(high, s.position[i]);
        group.middle = 0.5f * low + 0.5f * high, group.reach = glm::max(high - group.middle, group.middle - low);
        // √(sum of the principal 2×2 minors of a covariance), independent of the choice of axes. For a flat shape it measures the area seen
        // from its front.
        const auto shadow = [](const Mat3d& m) {
            return std::sqrt(std::max(0.0, m[0][0] * m[1][1] - m[0][1] * m[0][1] + m[0][0] * m[2][2] - m[0][2] * m[0][2] +
                                               m[1][1] * m[2][2] - m[1][2] * m[1][2]));
        };
        Vec3d sum(0);
        Mat3d squares(0);
        double all = 0, some = 0, n = 0;
        for (size_t k = 0; k < members.size(); ++k) {
            const uint32_t i = members[k];
            const Vec3d at = Vec3d(s.position[i]) - Vec3d(group.middle), v = Vec3d(s.scaleM[i]) * Vec3d(s.scaleM[i]);
            if (!std::isfinite(glm::dot(at, at) + v.x + v.y + v.z)) continue;
            const Mat3d turn(glm::mat3_cast(glm::dquat(s.rotation[i])));
            n += 1, sum += at, squares += glm::outerProduct(at, at);
            for (int a = 0; a < 3; ++a) squares += v[a] * glm::outerProduct(turn[a], turn[a]);
            const double covered = 2 * std::numbers::pi * double(s.opacity[i]) * std::sqrt(v.x * v.y + v.x * v.z + v.y * v.z);
            all += covered, some += covered * double(weightAt[k]);
        }
        // For points spread evenly over a rectangle, 12·√(var_x·var_y) is its area.
        group.detail = groupOf(12 * shadow(squares / n - glm::outerProduct(sum, sum) / (n * n)), uint32_t(members.size()), all, some);
    }
    return groups;
}

}  // namespace dpl
