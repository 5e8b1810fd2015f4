// SPDX-License-Identifier: Apache-2.0
// The clothing label of each triangle, by a vote of the pixels that see it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "reconstruction/subject/surface/mesh_raster.h"

namespace dpl {

/** Each person pixel that sees the front of a triangle votes for its own label, weighted by the cosine of the viewing angle. */
class TriangleLabels {
public:
    explicit TriangleLabels(size_t triangleCount) : triangleCount_(triangleCount) {}

    /** Adds a frame. `labels` and `mask` have the raster's size, one value per pixel. */
    void add(const MeshRaster& raster, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
             std::span<const uint8_t> labels, std::span<const uint8_t> mask);

    /** The label with most votes; the smaller label wins ties. First, two rounds in which neighbours share half of their votes remove
     * isolated labels. Unseen triangles take their neighbours' label, ring by ring, or `fallback` when no neighbour has one. */
    std::vector<uint8_t> finish(std::span<const Triangle> triangles, uint8_t fallback) const;

private:
    size_t triangleCount_;
    std::array<std::vector<float>, 256> votes_;  // of a label's value: one a triangle, or empty when no pixel has the label
};

}  // namespace dpl
