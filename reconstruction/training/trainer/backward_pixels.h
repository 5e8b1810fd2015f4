// SPDX-License-Identifier: Apache-2.0
// Backward pass of the blend: from a gradient image to one ScreenGradient a splat.
//
// The splats of a tile are replayed front to back. The blend's output is out = Σ αTc' with c' = (r, g, b, cloth, 1). With g the gradient
// on it, v_i = g·c'_i and rest_0 = g·out, a pixel needs two floats of state: the transmittance T, and `rest`, the part of g·out that comes
// from the splats behind:
//     rest_i = rest_{i−1} − α_i T_i v_i,   ∂/∂α_i = T_i v_i − rest_i/(1−α_i)
// Each (tile, entry) pair writes one record. The records of a splat are summed in tile order, so results do not depend on the number of
// threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/training/trainer/backward_chain.h"
#include "sdk/core/jobs.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {

/** ∂loss/∂SplatImage, planar, one float a pixel. `cloth` and the shares may be empty when the image was blended without cloth. */
struct ImageGradient {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<float> red, green, blue;  // wrt premultiplied colour
    std::vector<float> alpha, cloth;
    /** Share of a pixel's colour gradient that colours of splats of the body (0) and of cloth (1) take; as long as `cloth`. A picture of
     *  the one does not tell the colour of the other. */
    std::vector<float> colourShare[2];

    void resize(uint32_t width, uint32_t height, bool withCloth);
};

/** Sums of one (tile, entry) pair, or of one splat. s … syy are moments, about the splat's centre in pixels, of the gradient g_σ on the
 *  exponent σ in α = opacity'·exp(−σ). */
struct alignas(16) EntrySums {
    float s, sx, sy, sxx, sxy, syy;
    float red, green, blue;
    float weight;  // Σ αT, the splat's weight in the picture
    float pad0, pad1;
};
static_assert(sizeof(EntrySums) == 48);

class PixelBackward {
public:
    explicit PixelBackward(Jobs& jobs) : jobs_(jobs) {}

    /** Requires that `engine` last blended `image`, with recordStops, and with cloth when gradient.cloth is used. */
    void run(const SplatEngine& engine, const SplatImage& image, const ImageGradient& gradient);

    /** One entry a projected splat; zero for splats that touch no tile. Valid until the next run. */
    std::span<const EntrySums> sums() const { return sums_; }

private:
    Jobs& jobs_;
    std::vector<EntrySums> entries_, sums_;
};

/** The ScreenGradient of a splat from its sums. */
ScreenGradient<float> screenGradient(const ProjectedSplat& p, const EntrySums& s);

/** Number of (pixel, splat) pairs in the last blend of `engine`: pixels inside the splat's box that had not stopped before it. */
uint64_t countPixelSplatPairs(const SplatEngine& engine, uint32_t widthPx, uint32_t heightPx);

}  // namespace dpl
