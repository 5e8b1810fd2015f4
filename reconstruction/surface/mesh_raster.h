// SPDX-License-Identifier: Apache-2.0
// A small z-buffer for meshes in scan cameras: which triangle a pixel sees, and where on it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/math/camera.h"
#include "sdk/math/types.h"

namespace dpl {

constexpr uint32_t kNoTriangle = ~0u;

/** One entry a pixel, row-major; pixel centres at +0.5. */
struct MeshRaster {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint32_t> triangle;  // kNoTriangle where nothing is seen
    std::vector<Vec2f> barycentric;  // of corners 1 and 2, perspective-correct
    std::vector<float> depthM;       // view z; infinity where nothing is seen
};

/** Nearest front- or back-facing triangle per pixel centre; the lower index wins ties. Triangles that reach in front of 5 cm are left out.
 * One thread. */
MeshRaster rasteriseMesh(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera);

/** Intersection over union of the covered pixels with mask ≥ 128. 1 when both are empty. */
double silhouetteIou(const MeshRaster& raster, std::span<const uint8_t> mask);

/** Weighted mean colours of vertices, gathered from frames: what the stock-viewer colours and the report's floor are made of. */
class VertexColours {
public:
    explicit VertexColours(size_t vertexCount) : sum_(vertexCount, Vec3d(0)), weight_(vertexCount, 0) {}

    /** Adds a frame: rgb of 3 bytes a pixel, mask ≥ 128 is person; only pixels that see the front of a triangle count, weighted by cosine.
     */
    void add(const MeshRaster& raster, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
             std::span<const uint8_t> rgb, std::span<const uint8_t> mask);

    /** Colours in [0,255]; vertices that no frame saw take the mean of coloured neighbours, ring by ring. */
    std::vector<glm::u8vec4> finish(std::span<const Triangle> triangles) const;

private:
    std::vector<Vec3d> sum_;
    std::vector<double> weight_;
};

}  // namespace dpl
