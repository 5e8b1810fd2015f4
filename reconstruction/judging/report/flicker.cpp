// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/flicker.h"

#include <cmath>

#include "reconstruction/subject/surface/mesh_raster.h"

namespace dpl {
namespace {

constexpr long kOutlinePx = 2;
constexpr float kSamePlaceM = 0.005f;  // a point is seen when the raster's depth beside it is that near to its own
constexpr size_t kMinPixels = 64;

/** Whether the raster shows the surface everywhere within kOutlinePx of a pixel. */
bool farInside(const MeshRaster& raster, long x, long y) {
    if (x < kOutlinePx || y < kOutlinePx || x + kOutlinePx >= long(raster.widthPx) || y + kOutlinePx >= long(raster.heightPx)) return false;
    for (long dy = -kOutlinePx; dy <= kOutlinePx; ++dy)
        for (long dx = -kOutlinePx; dx <= kOutlinePx; ++dx)
            if (raster.triangle[size_t(y + dy) * raster.widthPx + size_t(x + dx)] == kNoTriangle) return false;
    return true;
}

/** Colour of a pixel over mid grey, [0, 255]. */
Vec3d overGrey(std::span<const uint8_t> rgba, size_t pixel) {
    const uint8_t* p = rgba.data() + 4 * pixel;
    const double alpha = p[3] / 255.0;
    return alpha * Vec3d(p[0], p[1], p[2]) + (1 - alpha) * Vec3d(127.5);
}

}  // namespace

std::optional<double> flickerLevels(const DrawnSurface& first, const DrawnSurface& second, std::span<const Triangle> triangles,
                                    const Camerad& camera) {
    const MeshRaster from = rasteriseMesh(first.positions, triangles, camera), to = rasteriseMesh(second.positions, triangles, camera);
    const size_t width = camera.widthPx;
    double sum = 0;
    size_t count = 0;
    for (long y = 0; y < long(camera.heightPx); ++y)
        for (long x = 0; x < long(width); ++x) {
            if (!farInside(from, x, y)) continue;
            const size_t pixel = size_t(y) * width + size_t(x);
            const Triangle& corner = triangles[from.triangle[pixel]];
            const Vec2d uv(from.barycentric[pixel]);
            const Vec3d point = (1 - uv.x - uv.y) * Vec3d(second.positions[corner.x]) + uv.x * Vec3d(second.positions[corner.y]) +
                                uv.y * Vec3d(second.positions[corner.z]);
            const Vec3d view = camera.toView(point);
            if (view.z <= 0) continue;
            const Vec2d place = camera.pixelOf(view);
            const long column = std::lround(place.x - 0.5), row = std::lround(place.y - 0.5);
            if (!farInside(to, column, row) || std::abs(to.depthM[size_t(row) * width + size_t(column)] - float(view.z)) > kSamePlaceM)
                continue;
            const double left = std::floor(place.x - 0.5), top = std::floor(place.y - 0.5), s = place.x - 0.5 - left,
                         t = place.y - 0.5 - top;
            const size_t at = size_t(top) * width + size_t(left);  // inside the picture, as farInside holds
            const Vec3d moved = (1 - t) * ((1 - s) * overGrey(second.rgba, at) + s * overGrey(second.rgba, at + 1)) +
                                t * ((1 - s) * overGrey(second.rgba, at + width) + s * overGrey(second.rgba, at + width + 1));
            const Vec3d difference = moved - overGrey(first.rgba, pixel);
            sum += glm::dot(difference, difference) / 3;
            ++count;
        }
    if (count < kMinPixels) return std::nullopt;
    return std::sqrt(sum / double(count));
}

}  // namespace dpl
