// How good a picture is: masked PSNR, SSIM and alpha IoU with the render's own straight alpha over white, black and grey.
#pragma once

#include <cstdint>
#include <span>

#include "reconstruction/splat/ssim.h"
#include "sdk/math/types.h"

namespace dpl {

/** A rendered picture, premultiplied: 3 floats a pixel and an alpha. */
struct ScoredRender {
    uint32_t widthPx = 0, heightPx = 0;
    std::span<const float> rgb, alpha;
};

/** What it is compared with: 8-bit colour (not premultiplied) and a mask of the same size. */
struct ScoredTruth {
    std::span<const uint8_t> rgb, mask;
};

struct PictureScore {
    double psnrMasked = 0;    // over mask ≥ 128 pixels
    double psnrBox = 0;       // over the person's box + 10 %
    double psnrFull = 0;      // whole picture
    double ssim = 0;          // mean over the person's box + 10 %
};

struct ImageScores {
    PictureScore white, black, grey;
    PictureScore worst;       // entry by entry
    double alphaIou = 0;      // alpha ≥ ½ against mask ≥ 128; 1 when both are empty
    double coverage = 0;      // share of the picture inside the mask
};

/** Both sides are composited on the same background: the render with its own alpha, the truth with its mask. */
ImageScores scoreImage(const ScoredRender& render, const ScoredTruth& truth, Jobs& jobs);

/** 8-bit premultiplied RGBA -> floats of ScoredRender. */
void unpackPremultiplied(std::span<const uint8_t> rgba, std::vector<float>& rgb, std::vector<float>& alpha);

constexpr double kPerfectPsnr = 99;  // reported when the error is zero

}  // namespace dpl
