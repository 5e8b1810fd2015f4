// SPDX-License-Identifier: Apache-2.0
// Scores of drawn pictures with alpha against frames, and the two floors that an avatar must beat (docs/reference/metrics.md).
#pragma once

#include <map>
#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/judging/report/report.h"

namespace dpl {

/** Scores an RGBA picture (straight alpha, 4 bytes per pixel) against a true one of the same size. The mask is where the truth's alpha is
 * at least 128. All scores are 0 when the mask is empty or the sizes differ. */
FrameScore scorePicture(const std::vector<uint8_t>& rgba, const std::vector<uint8_t>& truthRgba, uint32_t widthPx, uint32_t heightPx);
/** The same against a frame cut out by its mask. */
FrameScore scorePicture(const std::vector<uint8_t>& rgba, const ImageRgb8& truth, const ImageGrey8& mask);

/** A frame as an RGBA picture with alpha 255 where the mask is at least 128, else 0. Empty when the sizes differ. */
std::vector<uint8_t> cutOut(const ImageRgb8& image, const ImageGrey8& mask);

/** First floor: the mean colour per label over training frames, painted inside the true mask of a held-out frame. */
class LabelColours {
public:
    void add(const ImageRgb8& image, const ImageGrey8& mask, const ImageGrey8& labels);
    /** RGBA of the frame. Labels without a colour are mid grey. */
    std::vector<uint8_t> paint(const ImageGrey8& mask, const ImageGrey8& labels) const;

private:
    struct Sum {
        double rgb[3] = {0, 0, 0};
        double count = 0;
    };
    std::map<uint8_t, Sum> sums_;
};

/** Second floor: a posed mesh with vertex colours, drawn with the z-buffer of reconstruction/subject/surface. RGBA, alpha 0 or 255. */
std::vector<uint8_t> paintMesh(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const glm::u8vec4> colours,
                               const Camerad& camera);

/** An RGBA picture (straight alpha) resized by area averaging, colours weighted by alpha. */
std::vector<uint8_t> areaAveraged(const std::vector<uint8_t>& rgba, uint32_t widthPx, uint32_t heightPx, uint32_t toWidthPx,
                                  uint32_t toHeightPx);

/** The picture with alpha 0 wherever the 3 × 3 neighbourhood is not fully opaque. Scores against it ignore the outline. */
std::vector<uint8_t> insideOutline(const std::vector<uint8_t>& rgba, uint32_t widthPx, uint32_t heightPx);

/** RGB of an RGBA picture over white. */
std::vector<uint8_t> overWhite(const std::vector<uint8_t>& rgba);
/** Four times the absolute difference of two RGB pictures of the same size, clamped, for viewing. */
std::vector<uint8_t> differenceTimesFour(const std::vector<uint8_t>& rgb, const std::vector<uint8_t>& truthRgb);

}  // namespace dpl
