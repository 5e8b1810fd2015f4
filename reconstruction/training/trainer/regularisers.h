// SPDX-License-Identifier: Apache-2.0
// The terms of the loss on the parameters themselves, as opposed to pictures (docs/reference/losses.md).
#pragma once

#include <span>
#include <vector>

#include "reconstruction/training/trainer/trainable.h"

namespace dpl {

constexpr float kMaxSizeRatio = 0.6f;          // of a splat to h, below: larger ones are pulled
constexpr float kLogAnisotropy = 2.30258509f;  // ln 10: longer splats are pulled

struct RegulariserWeights {
    float scaleHinge = 1.0f;   // mean of max(0, s/h − 0.6), h = max(size of the splat's triangle, 8 mm)
    float anisotropy = 0.01f;  // mean of max(0, ln(s_max/s_min) − ln 10)
    float edgeRatio = 1e-2f;   // mean of max(0, ||e'|/|e| − 1| − 0.5)²
    float laplacian = 1e-2f;   // mean of |L ΔV|²/(mean edge)², L the uniform Laplacian divided by valence
    float collision = 1.0f;    // pull of 1 cm of garment inside the body, as a share of the picture's (garment_collision.h)
};

/** Adds the gradient of both splat terms to the rows of the active splats in [begin, end). referenceSizeM: h of each triangle. The terms
 *  divide by the number of all splats. */
void addSplatRegularisers(const TrainableSplats& splats, std::span<const float> referenceSizeM, std::span<const uint8_t> active,
                          const RegulariserWeights& weights, size_t begin, size_t end, std::span<float> rowGradients);
/** The value of the same terms, summed over the active splats. */
double splatRegulariserValue(const TrainableSplats& splats, std::span<const float> referenceSizeM, std::span<const uint8_t> active,
                             const RegulariserWeights& weights);

/** Edge and Laplacian terms of a mesh against its positions before any offset. */
class MeshRegulariser {
public:
    MeshRegulariser(std::span<const Vec3f> positions, std::span<const Triangle> triangles);
    /** Value of both mesh terms at the positions `moved`. Adds scale·∂value/∂moved to `gradient` unless it is empty. */
    double run(std::span<const Vec3f> moved, const RegulariserWeights& weights, float scale, std::span<Vec3f> gradient) const;

private:
    std::vector<Vec3f> rest_;
    std::vector<std::pair<uint32_t, uint32_t>> edges_;
    std::vector<float> length_, inverseValence_;
    float meanEdge_ = 1;
};

}  // namespace dpl
