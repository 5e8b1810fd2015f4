// SPDX-License-Identifier: Apache-2.0
#include "tests/viewer/room_depth.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dpl::test {
namespace {

constexpr double kNearM = 0.05;
// Vulkan's standard locations.
constexpr std::array<std::array<double, 2>, 4> kSamples{{{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}}};

/** The part of a triangle beyond the near plane: three or four corners, or none. */
std::vector<Vec3d> clipped(const std::array<Vec3d, 3>& view) {
    std::vector<Vec3d> out;
    for (size_t i = 0; i < 3; ++i) {
        const Vec3d a = view[i], b = view[(i + 1) % 3];
        if (a.z >= kNearM) out.push_back(a);
        if ((a.z < kNearM) != (b.z < kNearM)) out.push_back(a + (b - a) * ((kNearM - a.z) / (b.z - a.z)));
    }
    return out;
}

/** Writes the largest 1/z of each sample. */
void rasterise(const std::array<Vec3d, 3>& view, const Camerad& camera, std::vector<std::array<double, 4>>& inverse) {
    Vec2d p[3];
    for (size_t i = 0; i < 3; ++i) p[i] = camera.pixelOf(view[i]);
    const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
    if (!(area < 0)) return;  // seen from behind; y points down
    const auto low = [](double a, double b, double c) { return int(std::floor(std::min({a, b, c}))); };
    const auto high = [](double a, double b, double c) { return int(std::ceil(std::max({a, b, c}))); };
    const int x0 = std::max(0, low(p[0].x, p[1].x, p[2].x)), x1 = std::min(int(camera.widthPx), high(p[0].x, p[1].x, p[2].x));
    const int y0 = std::max(0, low(p[0].y, p[1].y, p[2].y)), y1 = std::min(int(camera.heightPx), high(p[0].y, p[1].y, p[2].y));
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
            for (size_t s = 0; s < kSamples.size(); ++s) {
                const Vec2d at(x + kSamples[s][0], y + kSamples[s][1]);
                const auto edge = [&](const Vec2d& a, const Vec2d& b) {
                    return ((b.x - a.x) * (at.y - a.y) - (b.y - a.y) * (at.x - a.x)) / area;
                };
                const double u = edge(p[1], p[2]), v = edge(p[2], p[0]), w = edge(p[0], p[1]);
                if (u < 0 || v < 0 || w < 0) continue;
                double& nearest = inverse[size_t(y) * camera.widthPx + size_t(x)][s];
                nearest = std::max(nearest, u / view[0].z + v / view[1].z + w / view[2].z);
            }
}

}  // namespace

std::vector<float> roomDepthM(const platform::RoomPlan& plan, const Camerad& camera) {
    std::vector<std::array<double, 4>> inverse(size_t(camera.widthPx) * camera.heightPx, {0, 0, 0, 0});
    const auto mesh = platform::roomMesh(plan);
    for (size_t i = 0; i < mesh.size(); i += 3) {
        std::array<Vec3d, 3> view;
        for (size_t k = 0; k < 3; ++k) {
            const float* p = mesh[i + k].position;
            view[k] = camera.toView({p[0], p[1], p[2]});
        }
        const std::vector<Vec3d> corners = clipped(view);
        for (size_t k = 2; k < corners.size(); ++k) rasterise({corners[0], corners[k - 1], corners[k]}, camera, inverse);
    }
    std::vector<float> depth;
    for (const auto& samples : inverse) {
        const double farthest = *std::min_element(samples.begin(), samples.end());
        depth.push_back(farthest > 0 ? float(1 / farthest) : 0);
    }
    return depth;
}

}  // namespace dpl::test
