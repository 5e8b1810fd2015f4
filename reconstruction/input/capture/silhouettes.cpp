// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/silhouettes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reconstruction/input/cameras/rays.h"

namespace dpl {
namespace {

constexpr double kNearestM = 0.05;  // of what a camera sees

struct Box2 {
    uint32_t x0 = UINT32_MAX, y0 = UINT32_MAX, x1 = 0, y1 = 0;  // [x0, x1) × [y0, y1)
    bool empty() const { return x1 <= x0; }
};

Box2 maskBox(const ImageGrey8& mask) {
    Box2 box;
    for (uint32_t y = 0; y < mask.heightPx; ++y)
        for (uint32_t x = 0; x < mask.widthPx; ++x)
            if (mask.pixels[size_t(y) * mask.widthPx + x] >= 128) {
                box.x0 = std::min(box.x0, x), box.x1 = std::max(box.x1, x + 1);
                box.y0 = std::min(box.y0, y), box.y1 = std::max(box.y1, y + 1);
            }
    return box;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

}  // namespace

std::optional<Vec3d> subjectCentre(std::span<const SilhouetteView> views) {
    std::vector<Ray> rays;
    for (const auto& view : views) {
        const Box2 box = maskBox(view.mask);
        if (!box.empty()) rays.push_back(pixelRay(view.camera, {0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)}));
    }
    const std::vector<double> weights(rays.size(), 1.0);
    const auto plain = pointNearRays(rays, weights, 0);
    if (!plain) return plain;
    double distance = 0;
    for (const Ray& ray : rays) distance += glm::length(*plain - ray.origin) / double(rays.size());
    return pointNearRays(rays, weights, 0.1 * distance);  // robust: a cut or wrong mask gets little weight
}

SilhouetteVotes voteSilhouettes(std::span<const SilhouetteView> views, const VoxelGrid& grid, Jobs& jobs) {
    SilhouetteVotes votes{std::vector<uint16_t>(grid.count(), 0), std::vector<uint16_t>(grid.count(), 0)};
    jobs.forBlocks(grid.nz, [&](size_t z, uint32_t) {
        for (const auto& view : views) {
            const Camerad& c = view.camera;
            const Vec3d stepX = c.viewFromWorldRotation * Vec3d(grid.voxelM, 0, 0);
            for (uint32_t y = 0; y < grid.ny; ++y) {
                const Vec3d first = c.toView(grid.centre(0, y, uint32_t(z)));
                const size_t row = grid.index(0, y, uint32_t(z));
                for (uint32_t x = 0; x < grid.nx; ++x) {
                    const Vec3d p = first + double(x) * stepX;
                    if (!(p.z > kNearestM)) continue;
                    const double u = c.fx * p.x / p.z + c.cx, v = c.fy * p.y / p.z + c.cy;
                    if (!(u >= 0 && v >= 0 && u < c.widthPx && v < c.heightPx)) continue;
                    ++votes.seen[row + x];
                    votes.inside[row + x] += view.mask.pixels[size_t(v) * view.mask.widthPx + size_t(u)] >= 128;
                }
            }
        }
    });
    return votes;
}

std::optional<VoxelGrid> boundSilhouettes(std::span<const SilhouetteView> views, double voxelM, double share, Jobs& jobs) {
    const auto centre = subjectCentre(views);
    if (!centre) return std::nullopt;
    std::vector<double> radii;
    for (const auto& view : views) {
        const Box2 box = maskBox(view.mask);
        const double depth = view.camera.toView(*centre).z;
        if (!box.empty() && depth > 0)
            radii.push_back(0.5 * depth * std::hypot((box.x1 - box.x0) / view.camera.fx, (box.y1 - box.y0) / view.camera.fy));
    }
    const double radius = 1.3 * median(radii);
    if (!(radius > 0)) return std::nullopt;
    constexpr uint32_t kCoarse = 72;
    const VoxelGrid coarse{*centre - Vec3d(radius), 2 * radius / kCoarse, kCoarse, kCoarse, kCoarse};
    const auto votes = voteSilhouettes(views, coarse, jobs);
    Vec3d low(1e30), high(-1e30);
    for (uint32_t z = 0; z < kCoarse; ++z)
        for (uint32_t y = 0; y < kCoarse; ++y)
            for (uint32_t x = 0; x < kCoarse; ++x)
                if (votes.isInside(coarse.index(x, y, z), share, views.size())) {
                    low = glm::min(low, coarse.centre(x, y, z));
                    high = glm::max(high, coarse.centre(x, y, z));
                }
    if (low.x > high.x) return std::nullopt;
    low -= 1.5 * coarse.voxelM, high += 1.5 * coarse.voxelM;  // the coarse grid may miss a hand thinner than a voxel
    const Vec3d size = high - low;
    if (voxelM <= 0) voxelM = std::max({size.x, size.y, size.z}) / 64;
    VoxelGrid grid{low - 2.0 * voxelM, voxelM};
    const Vec3d cells = glm::ceil(size / voxelM) + 4.0;
    if (cells.x * cells.y * cells.z > double(1u << 28)) return std::nullopt;
    grid.nx = uint32_t(cells.x), grid.ny = uint32_t(cells.y), grid.nz = uint32_t(cells.z);
    return grid;
}

double HullVoxels::nearestDepthM(const Camerad& camera) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3d& p : centres) {
        const Vec3d view = camera.toView(p);
        if (!(view.z > kNearestM && view.z < nearest)) continue;
        const Vec2d px = camera.pixelOf(view);
        if (px.x >= 0 && px.y >= 0 && px.x < camera.widthPx && px.y < camera.heightPx) nearest = view.z;
    }
    return nearest;
}

HullVoxels hullVoxels(const SilhouetteVotes& votes, const VoxelGrid& grid, double share, size_t viewCount) {
    HullVoxels hull{grid.voxelM, {}};
    for (uint32_t z = 0; z < grid.nz; ++z)
        for (uint32_t y = 0; y < grid.ny; ++y)
            for (uint32_t x = 0; x < grid.nx; ++x)
                if (votes.isInside(grid.index(x, y, z), share, viewCount)) hull.centres.push_back(grid.centre(x, y, z));
    return hull;
}

ImageGrey8 drawHull(const HullVoxels& hull, const Camerad& camera, double grow) {
    ImageGrey8 drawn{camera.widthPx, camera.heightPx, std::vector<uint8_t>(size_t(camera.widthPx) * camera.heightPx, 0)};
    for (const Vec3d& p : hull.centres) {
        const Vec3d view = camera.toView(p);
        if (!(view.z > kNearestM)) continue;
        const Vec2d px = camera.pixelOf(view);
        const double half = 0.5 * grow * hull.voxelM * camera.fx / view.z;
        if (!(px.x > -half && px.y > -half && px.x < camera.widthPx + half && px.y < camera.heightPx + half)) continue;
        const int x0 = std::max(0, int(px.x - half)), x1 = std::min(int(camera.widthPx) - 1, int(px.x + half));
        const int y0 = std::max(0, int(px.y - half)), y1 = std::min(int(camera.heightPx) - 1, int(px.y + half));
        for (int y = y0; y <= y1; ++y)
            std::fill(&drawn.pixels[size_t(y) * camera.widthPx + size_t(x0)], &drawn.pixels[size_t(y) * camera.widthPx + size_t(x1)] + 1,
                      uint8_t(255));
    }
    return drawn;
}

double silhouetteCoherence(std::span<const SilhouetteView> views, Jobs& jobs) {
    const auto grid = boundSilhouettes(views, 0, kHullShare, jobs);
    if (!grid) return 0;
    const HullVoxels hull = hullVoxels(voteSilhouettes(views, *grid, jobs), *grid, kHullShare, views.size());
    std::vector<double> covered(views.size(), 0);
    jobs.forBlocks(views.size(), [&](size_t i, uint32_t) {
        const auto& [camera, mask] = views[i];
        const ImageGrey8 drawn = drawHull(hull, camera, 1.8);  // projected diagonal of a voxel, about √3
        size_t person = 0, both = 0;
        for (size_t k = 0; k < drawn.pixels.size(); ++k) {
            const bool isPerson = mask.pixels[k] >= 128;
            person += isPerson;
            both += isPerson && drawn.pixels[k];
        }
        covered[i] = person ? double(both) / double(person) : 0;
    });
    return median(covered);
}

}  // namespace dpl
