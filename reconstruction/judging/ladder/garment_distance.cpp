// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/garment_distance.h"

#include <algorithm>

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

double pointDistanceM(const GarmentPair& garment, std::span<const Vec3f> restPositions, std::span<const Vec3f> positions,
                      std::span<const Vec3f> places) {
    double sum = 0, area = 0;
    for (const Triangle& t : garment.avatar) {
        const Vec3d a(restPositions[t.x]), b(restPositions[t.y]), c(restPositions[t.z]);
        const double twice = glm::length(glm::cross(b - a, c - a));
        for (int corner = 0; corner < 3; ++corner) sum += twice / 3 * glm::length(Vec3d(positions[t[corner]]) - Vec3d(places[t[corner]]));
        area += twice;
    }
    return area > 0 ? sum / area : 0;
}

GarmentPlaces::GarmentPlaces(const GarmentPair& garment, std::span<const Still> stills, Jobs& jobs)
    : vertexCount_(stills[0].positions.size()) {
    for (const Triangle& t : garment.avatar) vertices_.insert(vertices_.end(), {t.x, t.y, t.z});
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    const std::vector<uint8_t> all(garment.seenTruth.size(), 1);
    const auto own = [&](const std::vector<Vec3f>& of) {
        std::vector<Vec3f> out;
        for (const uint32_t v : vertices_) out.push_back(of[v]);
        return out;
    };
    const Still& first = stills[0];
    CarriedPoints mean(own(first.positions), own(first.normals), first.surface, garment.seenTruth, all, jobs);
    for (const Still& still : stills) mean.average(own(still.positions), still.surface);
    points_.emplace(mean.at(first.surface), own(first.normals), first.surface, garment.seenTruth, all, jobs);
}

std::vector<Vec3f> GarmentPlaces::at(std::span<const Vec3f> surface) const {
    const std::vector<Vec3f> places = points_->places(surface);
    std::vector<Vec3f> out(vertexCount_, Vec3f(0));
    for (size_t i = 0; i < vertices_.size(); ++i) out[vertices_[i]] = places[i];
    return out;
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
