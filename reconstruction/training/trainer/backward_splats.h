// SPDX-License-Identifier: Apache-2.0
// Second half of the backward pass: from gradients on screen records to parameter rows, triangles and posed vertices.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/training/trainer/backward_mesh.h"
#include "reconstruction/training/trainer/backward_pixels.h"
#include "reconstruction/training/trainer/trainable.h"

namespace dpl {

struct SplatBackwardInput {
    const TrainableSplats& splats;
    std::span<const TriangleFrame<float>> frames;
    TrianglesAtRest rest;
    const Cameraf& camera;
    std::span<const ProjectedSplat> projected;      // one a splat
    std::span<const ForwardRecord<float>> records;  // one a splat
    std::span<const EntrySums> sums;
};

class SplatBackward {
public:
    explicit SplatBackward(Jobs& jobs) : jobs_(jobs) {}

    /** Fills rowGradients() (N × stride) and active(). A splat that no pixel shows is inactive, and its row is not written. With
     *  `geometry`, also computes the corner gradients that gatherVertices() needs. */
    void run(const SplatBackwardInput& in, bool geometry);

    /** ∂loss/∂(posed vertices) and ∂loss/∂(vertex brightness), summed over each vertex's triangles in triangle order. Call it after a
     *  run with `geometry`. */
    void gatherVertices(const VertexIncidence& incidence, std::vector<Vec3f>& gPosed, std::vector<float>& gLight) const;

    std::span<float> rowGradients() { return rowGradients_; }
    std::span<const float> rowGradients() const { return rowGradients_; }
    std::span<const uint8_t> active() const { return active_; }
    std::span<uint8_t> active() { return active_; }
    /** |∂loss/∂(centre on the screen)| of each active splat, per pixel. */
    std::span<const float> screenGradientLength() const { return screenLength_; }

private:
    Jobs& jobs_;
    std::vector<float> rowGradients_, screenLength_;
    std::vector<uint8_t> active_;
    std::vector<Vec3f> corners_;  // 3 a triangle
    std::vector<float> lights_;   // 3 a triangle
};

}  // namespace dpl
