// SPDX-License-Identifier: Apache-2.0
// The picture's loss and its gradient on the blend: 0.8·L1 + 0.2·(1 − SSIM) on one random background, mask L1 on alpha, cloth label L1
// (docs/reference/losses.md).
#pragma once

#include <span>
#include <utility>

#include "reconstruction/splat/backward_pixels.h"
#include "reconstruction/splat/ssim.h"

namespace dpl {

/** What a frame should look like, cropped to the person, borrowed; planar, 255 is one, colour premultiplied by the mask. */
struct PictureTarget {
    uint32_t widthPx = 0, heightPx = 0;
    std::span<const uint8_t> rgb;    // three planes
    std::span<const uint8_t> mask;   // soft coverage
    std::span<const uint8_t> cloth;  // empty: no label loss
    std::span<const uint8_t> band;   // 1 within one pixel of the mask's edge: no colour loss there
};

struct LossWeights {
    float l1 = 0.8f, ssim = 0.2f, mask = 1.0f, cloth = 0.0f;
};

struct LossValues {
    double total = 0, l1 = 0, ssim = 0, mask = 0, cloth = 0;  // l1 … cloth unweighted; ssim is 1 − SSIM
    double squaredError = 0;                                  // Σ over mask ≥ ½ pixels and channels, composited on the background
    double squaredCount = 0;
};

class PictureLoss {
public:
    explicit PictureLoss(Jobs& jobs) : jobs_(jobs), ssim_(jobs) {}

    /** Loss of `image` (premultiplied, same size as the target) with both sides composited on `background`. Fills `gradient`.
     *  Pixels of the band take the rendered colour as their target, so they add no colour loss and get no colour gradient.
     *  Work is done in the box of what either side shows; beyond it both are background and every term is exactly zero. */
    LossValues run(const SplatImage& image, const PictureTarget& target, const LossWeights& weights, const Vec3f& background,
                   ImageGradient& gradient);

private:
    /** Pixels [x0, x1) × [y0, y1). */
    struct Box {
        uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    };
    Box shownBox(const SplatImage& image, const PictureTarget& target);

    Jobs& jobs_;
    std::vector<std::pair<uint32_t, uint32_t>> rowSpans_;
    Ssim ssim_;
    PlanarImage drawn_, wanted_, colourGradient_;
    std::vector<double> rowSums_;
};

}  // namespace dpl
