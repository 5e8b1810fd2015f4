// SPDX-License-Identifier: Apache-2.0
// A z-buffer rasteriser for meshes in scan cameras: the triangle that each pixel sees, and the position on it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/math/camera.h"
#include "sdk/math/types.h"

namespace dpl {

constexpr uint32_t kNoTriangle = ~0u;

/** One entry per pixel, row-major; pixel centres at +0.5. */
struct MeshRaster {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint32_t> triangle;  // kNoTriangle where nothing is seen
    std::vector<Vec2f> barycentric;  // of corners 1 and 2, perspective-correct
    std::vector<float> depthM;       // view z; infinity where nothing is seen
};

/** Finds the nearest triangle, front- or back-facing, at each pixel centre; the lower index wins ties. A triangle with a corner nearer than
 *  5 cm to the camera is left out. Runs on one thread. */
MeshRaster rasteriseMesh(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera);

/** Cosine between the normal of a triangle and the way from its first corner to the eye; above 0 the eye sees its front. */
double frontCosine(std::span<const Vec3f> positions, const Triangle& triangle, const Vec3d& eye);

/** By how much the view depth of a surface changes over one pixel. cosine > 0: between its normal and the way to the eye; viewZ: its depth.
 */
double recedingM(double cosine, double viewZ, const Camerad& camera);

/** Intersection over union of the covered pixels with mask ≥ 128. 1 when both are empty. */
double silhouetteIou(const MeshRaster& raster, std::span<const uint8_t> mask);

/** Weighted mean colours of vertices over frames. Used for the vertex colours of stock viewers and as the baseline in reports. */
class VertexColours {
public:
    explicit VertexColours(size_t vertexCount) : sum_(vertexCount, Vec3d(0)), weight_(vertexCount, 0) {}

    /** Adds a frame: rgb has 3 bytes per pixel, mask ≥ 128 is person. Only pixels that see the front of a triangle count; their weight is
     * the cosine of the viewing angle. */
    void add(const MeshRaster& raster, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
             std::span<const uint8_t> rgb, std::span<const uint8_t> mask);

    /** Colours in [0, 255]. Vertices that no frame saw take the mean of their coloured neighbours, ring by ring. */
    std::vector<glm::u8vec4> finish(std::span<const Triangle> triangles) const;

private:
    std::vector<Vec3d> sum_;
    std::vector<double> weight_;
};

}  // namespace dpl
