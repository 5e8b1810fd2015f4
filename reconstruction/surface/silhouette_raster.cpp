#include "reconstruction/surface/silhouette_raster.h"

#include <algorithm>
#include <cmath>

#include "sdk/math/projection.h"

namespace dpl {

TriangleImage rasteriseTriangles(const Camerad& camera, std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    TriangleImage out{camera.widthPx, camera.heightPx, {}, {}};
    const size_t pixels = size_t(camera.widthPx) * camera.heightPx;
    out.triangle.assign(pixels, kNoTriangle);
    out.depthM.assign(pixels, 3.4e38f);
    std::vector<Vec3d> screen(positions.size());  // x, y in pixels; 1/z
    for (size_t i = 0; i < positions.size(); ++i) {
        const Vec3d view = camera.toView(Vec3d(positions[i]));
        if (!(view.z > kNearM)) {
            screen[i] = Vec3d(0, 0, -1);
            continue;
        }
        screen[i] = Vec3d(camera.pixelOf(view), 1 / view.z);
    }
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        const Vec3d &a = screen[triangles[t].x], &b = screen[triangles[t].y], &c = screen[triangles[t].z];
        if (a.z < 0 || b.z < 0 || c.z < 0) continue;
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (!(std::abs(area) > 1e-12)) continue;
        // Pixel centres at +0.5; the box is cut to the picture before it becomes integers.
        const double left = std::max(0.0, std::floor(std::min({a.x, b.x, c.x}) - 0.5)),
                     right = std::min(double(camera.widthPx) - 1, std::ceil(std::max({a.x, b.x, c.x}) - 0.5));
        const double top = std::max(0.0, std::floor(std::min({a.y, b.y, c.y}) - 0.5)),
                     bottom = std::min(double(camera.heightPx) - 1, std::ceil(std::max({a.y, b.y, c.y}) - 0.5));
        if (!(left <= right) || !(top <= bottom)) continue;
        const double inverse = 1 / area;
        for (int y = int(top); y <= int(bottom); ++y)
            for (int x = int(left); x <= int(right); ++x) {
                const double px = x + 0.5, py = y + 0.5;
                const double wb = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) * inverse;
                const double wc = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) * inverse;
                if (wb < 0 || wc < 0 || wb + wc > 1) continue;
                const float depth = float(1 / (a.z + wb * (b.z - a.z) + wc * (c.z - a.z)));
                const size_t i = size_t(y) * camera.widthPx + size_t(x);
                if (depth < out.depthM[i]) out.depthM[i] = depth, out.triangle[i] = t;
            }
    }
    return out;
}

double silhouetteIou(const TriangleImage& image, std::span<const uint8_t> mask) {
    size_t both = 0, either = 0;
    for (size_t i = 0; i < image.triangle.size() && i < mask.size(); ++i) {
        const bool a = image.triangle[i] != kNoTriangle, b = mask[i] >= 128;
        both += a && b;
        either += a || b;
    }
    return either ? double(both) / double(either) : 1;
}

}  // namespace dpl
