// SPDX-License-Identifier: Apache-2.0
// Which clothing label each triangle wears, voted by the frames that see it.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/surface/mesh_raster.h"

namespace dpl {

/** Collects votes: each pixel on the front of a triangle votes for its label, weighted by cosine; background pixels do not vote. */
class TriangleLabels {
public:
    explicit TriangleLabels(size_t triangleCount) : votes_(triangleCount) {}

    /** labels and mask: one value a pixel of the raster's size. */
    void add(const MeshRaster& raster, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
             std::span<const uint8_t> labels, std::span<const uint8_t> mask);

    /** The label with most votes, after two rounds in which neighbours share half of theirs (lone triangles follow their surroundings).
     *  Triangles that nobody saw take their neighbours' label, ring by ring; `fallback` where nothing was seen at all. Ties: the smaller
     * label. */
    std::vector<uint8_t> finish(std::span<const Triangle> triangles, uint8_t fallback) const;

private:
    static constexpr size_t kLabels = 8;
    struct Votes {
        float byLabel[kLabels] = {};
    };
    std::vector<Votes> votes_;
};

}  // namespace dpl
