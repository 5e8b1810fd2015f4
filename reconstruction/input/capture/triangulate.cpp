// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/triangulate.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr double kSeen = 0.25;  // minimum confidence of a keypoint for triangulation
constexpr double kMinParallaxRad = 0.1;

}  // namespace

std::vector<std::optional<Vec3d>> triangulateKeypoints(const std::vector<KeypointView>& views, size_t keypointCount) {
    std::vector<std::optional<Vec3d>> points(keypointCount);
    for (size_t k = 0; k < keypointCount; ++k) {
        struct Ray {
            Vec3d eye, direction;
            double weight;
        };
        std::vector<Ray> rays;
        for (const KeypointView& v : views) {
            if (!v.keypoints || k >= v.keypoints->size()) continue;
            const Keypoint& p = (*v.keypoints)[k];
            if (p.confidence < kSeen) continue;
            const Vec3d inView((p.px.x - v.camera.cx) / v.camera.fx, (p.px.y - v.camera.cy) / v.camera.fy, 1);
            rays.push_back(
                {v.camera.eye(), glm::normalize(glm::transpose(v.camera.viewFromWorldRotation) * inView), p.confidence * p.confidence});
        }
        if (rays.size() < 2) continue;
        double parallax = 0;
        for (const Ray& r : rays)
            parallax = std::max(parallax, std::acos(std::clamp(std::abs(glm::dot(r.direction, rays[0].direction)), 0.0, 1.0)));
        if (parallax < kMinParallaxRad) continue;
        // Least squares of the distances to the rays, reweighted by 1/(1+(d/m)²) with m the median distance.
        Vec3d x(0);
        std::vector<double> robust(rays.size(), 1.0);
        bool solved = false;
        for (int round = 0; round < 6; ++round) {
            Mat3d a(0.0);
            Vec3d b(0);
            for (size_t i = 0; i < rays.size(); ++i) {
                const Mat3d m = rays[i].weight * robust[i] * (Mat3d(1.0) - glm::outerProduct(rays[i].direction, rays[i].direction));
                a += m;
                b += m * rays[i].eye;
            }
            if (!(std::abs(glm::determinant(a)) > 1e-12)) break;
            x = glm::inverse(a) * b;
            solved = true;
            std::vector<double> distances, sorted;
            for (const Ray& r : rays) {
                const Vec3d d = x - r.eye;
                distances.push_back(glm::length(d - glm::dot(d, r.direction) * r.direction));
            }
            sorted = distances;
            std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
            const double median = std::max(sorted[sorted.size() / 2], 1e-9);
            for (size_t i = 0; i < rays.size(); ++i) robust[i] = 1 / (1 + distances[i] * distances[i] / (median * median));
        }
        if (solved) points[k] = x;
    }
    return points;
}

}  // namespace dpl
