// SPDX-License-Identifier: Apache-2.0
// Second half of the backward pass: gradients on screen records -> parameter rows, triangles and posed vertices.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/splat/backward_mesh.h"
#include "reconstruction/splat/backward_pixels.h"
#include "reconstruction/splat/trainable.h"

namespace dpl {

struct SplatBackwardInput {
    const TrainableSplats& splats;
    std::span<const TriangleFrame<float>> frames;
    std::span<const RestTriangle<float>> rest;
    const Cameraf& camera;
    std::span<const ProjectedSplat> projected;      // one a splat
    std::span<const ForwardRecord<float>> records;  // one a splat
    std::span<const EntrySums> sums;
};

class SplatBackward {
public:
    explicit SplatBackward(Jobs& jobs) : jobs_(jobs) {}

    /** Fills rowGradients (N × stride) and active; rows of splats that nothing saw are left untouched and inactive. With
     *  `geometry`, also the corner gradients that gatherVertices() needs. */
    void run(const SplatBackwardInput& in, bool geometry);

    /** ∂loss/∂(posed vertices) and ∂loss/∂(brightness of the vertices), summed over each vertex's triangles in triangle order.
     *  After run(geometry = true). */
    void gatherVertices(const VertexIncidence& incidence, std::vector<Vec3f>& gPosed, std::vector<float>& gLight) const;

    std::span<float> rowGradients() { return rowGradients_; }
    std::span<const float> rowGradients() const { return rowGradients_; }
    std::span<const uint8_t> active() const { return active_; }
    /** |∂loss/∂centre| of each active splat, per pixel of displacement. */
    std::span<const float> screenGradientLength() const { return screenLength_; }

private:
    Jobs& jobs_;
    std::vector<float> rowGradients_, screenLength_;
    std::vector<uint8_t> active_;
    std::vector<Vec3f> corners_;  // 3 a triangle
    std::vector<float> lights_;   // 3 a triangle
};

}  // namespace dpl
