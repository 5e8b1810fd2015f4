// A small z-buffer for silhouettes: which triangle is nearest at each pixel centre.
#pragma once

#include <span>
#include <vector>

#include "sdk/math/camera.h"

namespace dpl {

constexpr uint32_t kNoTriangle = UINT32_MAX;

struct TriangleImage {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint32_t> triangle;  // kNoTriangle: background
    std::vector<float> depthM;       // view z; undefined on the background

    bool covered(uint32_t x, uint32_t y) const { return triangle[size_t(y) * widthPx + x] != kNoTriangle; }
};

/** Rasterises world-space triangles, front and back faces alike. Triangles that touch the near plane (0.05 m) are left out. One thread;
 *  the lower triangle index wins ties, so the result is the same everywhere. */
TriangleImage rasteriseTriangles(const Camerad& camera, std::span<const Vec3f> positions, std::span<const Triangle> triangles);

/** Intersection over union of the covered pixels with mask ≥ 128. 1 when both are empty. */
double silhouetteIou(const TriangleImage& image, std::span<const uint8_t> mask);

}  // namespace dpl
