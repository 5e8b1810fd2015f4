// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/garment_distance.h"

#include "reconstruction/subject/shape/closest_surface.h"

namespace dpl {
namespace {

/** Mean over the area of a surface of the distance to another. */
double meanDistanceM(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const ClosestSurface& to, Jobs& jobs) {
    std::vector<float> distances(triangles.size());
    jobs.forRange(triangles.size(), 256, [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t) {
            const Triangle& c = triangles[t];
            distances[t] = to.find((positions[c.x] + positions[c.y] + positions[c.z]) / 3.0f).distanceM;
        }
    });
    double sum = 0, area = 0;
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Vec3d a(positions[triangles[t].x]), b(positions[triangles[t].y]), c(positions[triangles[t].z]);
        const double twice = glm::length(glm::cross(b - a, c - a));
        sum += twice * double(distances[t]), area += twice;
    }
    return area > 0 ? sum / area : 0;
}

}  // namespace

double garmentDistanceM(const GarmentPair& garment, std::span<const Vec3f> avatarPositions, std::span<const Vec3f> truePositions,
                        Jobs& jobs) {
    if (garment.avatar.empty() || garment.truth.empty()) return 0;
    return 0.5 * (meanDistanceM(avatarPositions, garment.avatar, ClosestSurface(truePositions, garment.truth), jobs) +
                  meanDistanceM(truePositions, garment.seenTruth, ClosestSurface(avatarPositions, garment.avatar), jobs));
}

std::vector<GarmentPair> garmentPairs(const MeshData& avatar, const TrueMesh& truth, std::span<const uint8_t> seen) {
    std::vector<GarmentPair> pairs;
    for (const LayerData& layer : avatar.layers) {
        if (layer.role != "garment") continue;
        GarmentPair pair{layer.name, {}, {}, {}};
        for (const TruePart& part : truth.parts)
            for (uint32_t t = part.firstTriangle; part.cloth && part.label == layer.name && t < part.firstTriangle + part.triangleCount;
                 ++t) {
                pair.truth.push_back(truth.triangles[t]);
                if (seen[t]) pair.seenTruth.push_back(truth.triangles[t]);
            }
        if (pair.seenTruth.empty() || layer.triangleCount == 0) continue;
        const auto first = avatar.triangles.begin() + std::ptrdiff_t(layer.firstTriangle);
        pair.avatar.assign(first, first + std::ptrdiff_t(layer.triangleCount));
        pairs.push_back(std::move(pair));
    }
    return pairs;
}

}  // namespace dpl
