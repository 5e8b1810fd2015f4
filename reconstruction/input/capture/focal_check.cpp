// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/focal_check.h"

#include <cmath>

#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr size_t kFewestRays = 4, kFewestMisses = 20;

Camerad scaled(Camerad camera, double factor) {
    camera.fx *= factor, camera.fy *= factor;
    return camera;
}

}  // namespace

std::vector<double> missesPx(std::span<const KeypointTrack> tracks, double factor) {
    std::vector<double> misses;
    for (const KeypointTrack& track : tracks) {
        if (track.size() < kFewestRays) continue;
        std::vector<Ray> rays;
        std::vector<double> weights;
        for (const SeenKeypoint& seen : track)
            rays.push_back(pixelRay(scaled(seen.camera, factor), seen.px)), weights.push_back(seen.confidence);
        double spread = 0;
        for (const Ray& ray : rays) spread += glm::length(ray.origin - rays[0].origin) / double(rays.size());
        const auto point = pointNearRays(rays, weights, std::max(1e-3, 0.02 * spread));
        if (!point) continue;
        for (const SeenKeypoint& seen : track) {
            const Camerad camera = scaled(seen.camera, factor);
            const Vec3d view = camera.toView(*point);
            if (view.z > 0.05) misses.push_back(glm::length(camera.pixelOf(view) - seen.px));
        }
    }
    return misses;
}

std::optional<FocalEstimate> estimateFocalFactor(std::span<const KeypointTrack> tracks) {
    if (missesPx(tracks, 1).size() < kFewestMisses) return std::nullopt;
    const auto miss = [&](double logFactor) { return percentile(missesPx(tracks, std::exp(logFactor)), 0.5); };
    // The median has many small dips, so a grid finds the valley and finer grids its floor.
    const double asGiven = miss(0);
    double at = 0, best = asGiven;
    for (double reach = std::log(2.0), step = reach / 14; step > 0.002; reach = 2 * step, step /= 4) {
        const double centre = at;
        for (double x = centre - reach; x <= centre + reach + 1e-9; x += step)
            if (const double m = miss(x); m < best) best = m, at = x;
    }
    return FocalEstimate{std::exp(at), best, asGiven};
}

}  // namespace dpl
