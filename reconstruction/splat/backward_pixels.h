// SPDX-License-Identifier: Apache-2.0
// Backward of the blend: gradient image -> one ScreenGradient a splat.
//
// Forward-order replay. The loss sees the blend only through Σ αTc', c' = (r, g, b, cloth, 1), so with v_i = g·c'_i and
// V = g·out every pixel needs two floats of state, T and the part of V that lies behind:
//     rest_i = rest_{i−1} − α_i T_i v_i,   ∂/∂α_i = T_i v_i − rest_i/(1−α_i)
// Each (tile, entry) pair writes one record; records are then summed per splat in tile order, so results do not depend on threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/splat/backward_chain.h"
#include "sdk/core/jobs.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {

/** ∂loss/∂SplatImage, planar, one float a pixel. `cloth` may be empty when the image was blended without it. */
struct ImageGradient {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<float> red, green, blue;  // wrt premultiplied colour
    std::vector<float> alpha, cloth;

    void resize(uint32_t width, uint32_t height, bool withCloth);
};

/** One float record of a (tile, entry) pair: moments of g_σ about the splat's centre, colour gradients, blending weight. */
struct alignas(16) EntrySums {
    float s, sx, sy, sxx, sxy, syy;
    float red, green, blue;
    float weight;  // Σ αT: how much of the picture is this splat
    float pad0, pad1;
};
static_assert(sizeof(EntrySums) == 48);

class PixelBackward {
public:
    explicit PixelBackward(Jobs& jobs) : jobs_(jobs) {}

    /** `engine` has just blended `image` with recordStops (and cloth, when gradient.cloth is used). */
    void run(const SplatEngine& engine, const SplatImage& image, const ImageGradient& gradient);

    /** One entry a projected splat; zero for splats in no tile. Valid until the next run. */
    std::span<const EntrySums> sums() const { return sums_; }

private:
    Jobs& jobs_;
    std::vector<EntrySums> entries_, sums_;
};

/** ScreenGradient of a splat from its sums. */
ScreenGradient<float> screenGradient(const ProjectedSplat& p, const EntrySums& s);

/** Number of (pixel, splat) pairs that the last blend of `engine` evaluated inside splat boxes and before each pixel's stop. */
uint64_t countPixelSplatPairs(const SplatEngine& engine, uint32_t widthPx, uint32_t heightPx);

}  // namespace dpl
