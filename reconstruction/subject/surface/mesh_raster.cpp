// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/mesh_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reconstruction/input/capture/frame_picture.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

double edge(const Vec2d& a, const Vec2d& b, const Vec2d& p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

}  // namespace

MeshRaster rasteriseMesh(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera) {
    MeshRaster raster;
    const int width = int(camera.widthPx), height = int(camera.heightPx);
    const size_t pixels = size_t(width) * size_t(height);
    raster.widthPx = camera.widthPx, raster.heightPx = camera.heightPx;
    raster.triangle.assign(pixels, kNoTriangle);
    raster.barycentric.assign(pixels, Vec2f(0));
    raster.depthM.assign(pixels, std::numeric_limits<float>::infinity());

    std::vector<Vec3d> view(positions.size());
    for (size_t v = 0; v < positions.size(); ++v) view[v] = camera.toView(Vec3d(positions[v]));
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Vec3d &a = view[triangles[t].x], &b = view[triangles[t].y], &c = view[triangles[t].z];
        if (!(a.z > kNearM && b.z > kNearM && c.z > kNearM)) continue;
        const Vec2d pa = camera.pixelOf(a), pb = camera.pixelOf(b), pc = camera.pixelOf(c);
        const double area = edge(pa, pb, pc);
        if (!(std::abs(area) > 1e-12) || !std::isfinite(area)) continue;
        const double lowX = std::min({pa.x, pb.x, pc.x}), highX = std::max({pa.x, pb.x, pc.x});
        const double lowY = std::min({pa.y, pb.y, pc.y}), highY = std::max({pa.y, pb.y, pc.y});
        if (highX < 0 || highY < 0 || lowX > width || lowY > height) continue;
        const int x0 = int(std::max(0.0, std::ceil(lowX - 0.5))), x1 = int(std::min(width - 1.0, std::floor(highX - 0.5)));
        const int y0 = int(std::max(0.0, std::ceil(lowY - 0.5))), y1 = int(std::min(height - 1.0, std::floor(highY - 0.5)));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const Vec2d p(x + 0.5, y + 0.5);
                const double wa = edge(pb, pc, p) / area, wb = edge(pc, pa, p) / area, wc = 1 - wa - wb;
                if (wa < 0 || wb < 0 || wc < 0) continue;
                const double inverseZ = wa / a.z + wb / b.z + wc / c.z;
                const float z = float(1 / inverseZ);
                const size_t pixel = size_t(y) * size_t(width) + size_t(x);
                if (!(z < raster.depthM[pixel])) continue;
                raster.depthM[pixel] = z;
                raster.triangle[pixel] = uint32_t(t);
                raster.barycentric[pixel] = {float(wb / b.z / inverseZ), float(wc / c.z / inverseZ)};
            }
    }
    return raster;
}

double frontCosine(std::span<const Vec3f> positions, const Triangle& triangle, const Vec3d& eye) {
    const Vec3d a(positions[triangle.x]), b(positions[triangle.y]), c(positions[triangle.z]);
    const Vec3d normal = glm::cross(b - a, c - a), toEye = eye - a;
    return glm::dot(normal, toEye) / std::max(1e-20, glm::length(normal) * glm::length(toEye));
}

double recedingM(double cosine, double viewZ, const Camerad& camera) {
    return std::sqrt(1 - std::min(1.0, cosine * cosine)) / cosine * viewZ / camera.fx;
}

double silhouetteIou(const MeshRaster& raster, std::span<const uint8_t> mask) {
    size_t both = 0, either = 0;
    for (size_t i = 0; i < raster.triangle.size() && i < mask.size(); ++i) {
        const bool drawn = raster.triangle[i] != kNoTriangle, person = isPerson(mask[i]);
        both += drawn && person;
        either += drawn || person;
    }
    return either ? double(both) / double(either) : 1;
}

void VertexColours::add(const MeshRaster& raster, std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                        const Camerad& camera, std::span<const uint8_t> rgb, std::span<const uint8_t> mask) {
    const Vec3d eye = camera.eye();
    for (size_t pixel = 0; pixel < raster.triangle.size(); ++pixel) {
        if (raster.triangle[pixel] == kNoTriangle || !isPerson(mask[pixel])) continue;
        const Triangle& t = triangles[raster.triangle[pixel]];
        const double cosine = frontCosine(positions, t, eye);
        if (cosine < 0.1) continue;
        const Vec2f uv = raster.barycentric[pixel];
        const double weights[3] = {1.0 - uv.x - uv.y, uv.x, uv.y};
        const Vec3d colour(rgb[pixel * 3], rgb[pixel * 3 + 1], rgb[pixel * 3 + 2]);
        for (int k = 0; k < 3; ++k) {
            const double w = weights[k] * cosine;
            sum_[t[k]] += w * colour;
            weight_[t[k]] += w;
        }
    }
}

std::vector<glm::u8vec4> VertexColours::finish(std::span<const Triangle> triangles) const {
    std::vector<Vec3d> colour(sum_.size(), Vec3d(128));
    std::vector<uint8_t> known(sum_.size(), 0);
    for (size_t v = 0; v < sum_.size(); ++v)
        if (weight_[v] > 1e-3) colour[v] = sum_[v] / weight_[v], known[v] = 1;
    for (bool grew = true; grew;) {
        grew = false;
        std::vector<Vec3d> sum(sum_.size(), Vec3d(0));
        std::vector<uint32_t> count(sum_.size(), 0);
        for (const Triangle& t : triangles)
            for (int k = 0; k < 3; ++k)
                for (int j = 1; j < 3; ++j) {
                    const uint32_t v = t[k], from = t[(k + j) % 3];
                    if (!known[v] && known[from]) sum[v] += colour[from], ++count[v];
                }
        for (size_t v = 0; v < sum.size(); ++v)
            if (count[v] > 0) colour[v] = sum[v] / double(count[v]), known[v] = 1, grew = true;
    }
    std::vector<glm::u8vec4> out(colour.size());
    for (size_t v = 0; v < out.size(); ++v) out[v] = glm::u8vec4(glm::clamp(colour[v] + 0.5, 0.0, 255.0), 255);
    return out;
}

}  // namespace dpl
