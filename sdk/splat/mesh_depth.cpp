// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/mesh_depth.h"

#include <algorithm>
#include <limits>

#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr size_t kVertexGrain = 4096, kTriangleGrain = 2048, kBandRows = 32;
constexpr float kNear = float(kNearM), kNone = std::numeric_limits<float>::infinity();

/** Range [first, end) of the pixels whose centres lie in [low − margin, high + margin], cut to the target. The margin covers rounding. */
void pixelsIn(float low, float high, float margin, uint32_t size, uint16_t& first, uint16_t& end) {
    const float top = float(size);
    first = uint16_t(std::clamp(std::ceil(low - 0.5f - margin), 0.0f, top));
    end = uint16_t(std::clamp(std::floor(high - 0.5f + margin) + 1, 0.0f, top));
}

/** Draws one triangle into columns [x0, x1) of the row of pixels whose centres are at y. Without branches, so that it vectorises. */
void drawRow(const Vec3f (&c)[3], uint32_t x0, uint32_t x1, float y, float* depth) {
    const float v0 = c[0].y - c[0].z * y, v1 = c[1].y - c[1].z * y, v2 = c[2].y - c[2].z * y;
    for (uint32_t x = x0; x < x1; ++x) {
        const float px = float(x) + 0.5f;
        const float u0 = c[0].x - c[0].z * px, u1 = c[1].x - c[1].z * px, u2 = c[2].x - c[2].z * px;
        const float e0 = u1 * v2 - u2 * v1, e1 = u2 * v0 - u0 * v2, e2 = u0 * v1 - u1 * v0;
        const float least = std::min(e0, std::min(e1, e2)), most = std::max(e0, std::max(e1, e2));
        const float z = (e0 * c[0].z + e1 * c[1].z + e2 * c[2].z) / (e0 + e1 + e2);
        const bool there = ((least >= 0) | (most <= 0)) & (z > kNear) & (z < depth[x]);  // false where z is 0/0
        depth[x] = there ? z : depth[x];
    }
}

}  // namespace

MeshDepth::PixelBox MeshDepth::boxOf(const Vec3f (&c)[3], uint32_t widthPx, uint32_t heightPx) {
    Vec2f low(kNone), high(-kNone);
    const auto take = [&](const Vec2f& p) { low = glm::min(low, p), high = glm::max(high, p); };
    bool crosses = false, finite = true;
    for (int i = 0; i < 3; ++i) {
        const Vec3f &a = c[i], &b = c[(i + 1) % 3];
        finite &= std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
        if (a.z > kNear) take(Vec2f(a) / a.z);
        if ((a.z > kNear) == (b.z > kNear)) continue;
        crosses = true;
        const float t = (kNear - a.z) / (b.z - a.z);
        take((Vec2f(a) + t * (Vec2f(b) - Vec2f(a))) / kNear);
    }
    PixelBox box{};
    if (!finite || !(low.x <= high.x)) return box;
    const float margin = crosses ? 1.0f : 0.01f;  // px; wider when the triangle crosses the near plane
    pixelsIn(low.x, high.x, margin, widthPx, box.x0, box.x1);
    pixelsIn(low.y, high.y, margin, heightPx, box.y0, box.y1);
    return box;
}

void MeshDepth::draw(Jobs& jobs, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const SubjectView& view,
                     std::vector<float>& depthM) {
    const Cameraf& camera = view.camera;
    const uint32_t width = camera.widthPx, height = camera.heightPx;
    depthM.resize(size_t(width) * height);
    corners_.resize(positions.size());
    boxes_.resize(triangles.size());
    jobs.forRange(positions.size(), kVertexGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) {
            const Vec3f p = view.toView(positions[i]);
            corners_[i] = {camera.fx * p.x + camera.cx * p.z, camera.fy * p.y + camera.cy * p.z, p.z};
        }
    });
    jobs.forRange(triangles.size(), kTriangleGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t)
            boxes_[t] = boxOf({corners_[triangles[t].x], corners_[triangles[t].y], corners_[triangles[t].z]}, width, height);
    });
    jobs.forBlocks((height + kBandRows - 1) / kBandRows, [&](size_t band, uint32_t) {
        const uint32_t top = uint32_t(band * kBandRows), bottom = std::min<uint32_t>(top + kBandRows, height);
        float* first = depthM.data() + size_t(top) * width;
        std::fill_n(first, size_t(bottom - top) * width, kNone);
        for (size_t t = 0; t < triangles.size(); ++t) {
            const PixelBox& box = boxes_[t];
            const uint32_t y0 = std::max<uint32_t>(box.y0, top), y1 = std::min<uint32_t>(box.y1, bottom);
            if (y0 >= y1 || box.x0 >= box.x1) continue;
            uint32_t index[3] = {triangles[t].x, triangles[t].y, triangles[t].z};
            std::sort(index, index + 3);
            const Vec3f corners[3] = {corners_[index[0]], corners_[index[1]], corners_[index[2]]};
            for (uint32_t y = y0; y < y1; ++y) drawRow(corners, box.x0, box.x1, float(y) + 0.5f, depthM.data() + size_t(y) * width);
        }
        std::replace(first, depthM.data() + size_t(bottom) * width, kNone, 0.0f);
    });
}

}  // namespace dpl
