// SPDX-License-Identifier: Apache-2.0
// The loss of a picture and its gradient on the blended image: 0.8·L1 + 0.2·(1 − SSIM) over one random background, L1 of alpha against the
// mask, and L1 of the cloth label (docs/reference/losses.md).
#pragma once

#include <optional>
#include <span>
#include <utility>

#include "reconstruction/training/trainer/backward_pixels.h"
#include "reconstruction/training/trainer/ssim.h"

namespace dpl {

/** The target of a frame, cropped to the person; borrowed. Planar, 8 bits (255 is 1.0), colour premultiplied by the mask or by `shown`. */
struct PictureTarget {
    uint32_t widthPx = 0, heightPx = 0;
    std::span<const uint8_t> rgb;    // three planes
    std::span<const uint8_t> mask;   // soft coverage of the person
    std::span<const uint8_t> cloth;  // empty: no label loss
    // At the edge of the mask, unless empty, the target is the picture itself, background included.
    std::span<const uint8_t> shown;   // coverage of `rgb`: the person and the edge
    std::span<const uint8_t> unsure;  // coverage of the edge
    std::span<const uint8_t> behind;  // three planes: what lies behind the person there, premultiplied by `unsure`
    float edgeMaskWeight = 1;         // of the mask loss there, relative to elsewhere
};

/** Says which target it is, so that an engine keeps it. Two targets of one training with the same name are the same. */
struct TargetName {
    uint32_t frame = 0;
    int level = 0;
    bool operator==(const TargetName&) const = default;
};

struct LossWeights {
    float l1 = 0.8f, ssim = 0.2f, mask = 1.0f, cloth = 0.0f;
};

struct LossValues {
    double total = 0, l1 = 0, ssim = 0, mask = 0, cloth = 0;  // l1 … cloth are unweighted, but for the edge; ssim is 1 − SSIM
    double squaredError = 0;                                  // over channels of pixels with mask ≥ ½, over the background
    double squaredCount = 0;
};

class PictureLoss {
public:
    explicit PictureLoss(Jobs& jobs) : jobs_(jobs), ssim_(jobs) {}

    /** Loss of `image` (premultiplied, same size as the target), with image and target composited over `background`; the edge's part of a
     *  pixel over what lies behind. Fills `gradient`.
     *  Only the box around the drawn and the wanted pixels is computed. Outside it both show the background, and every term is zero. */
    LossValues run(const SplatImage& image, const PictureTarget& target, const LossWeights& weights, const Vec3f& background,
                   ImageGradient& gradient);

private:
    /** The pixels [x0, x1) × [y0, y1). */
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
