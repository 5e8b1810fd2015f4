// SPDX-License-Identifier: Apache-2.0
// SIFT features of pictures and their matches. Uses OpenCV's SIFT; nothing is random.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/input/cameras/camera_check.h"

namespace dpl {

constexpr uint32_t kFeatureBytes = 128;

/** Features of one picture. */
struct Features {
    std::vector<Vec2d> px;             // in the stored picture, centres at +0.5
    std::vector<uint8_t> descriptors;  // kFeatureBytes each
    size_t size() const { return px.size(); }
};

/** An 8-bit grey picture that somebody else owns. */
struct GreyView {
    uint32_t widthPx = 0, heightPx = 0;
    std::span<const uint8_t> pixels;  // row by row, widthPx · heightPx
};

/** The `most` strongest features where `where` is not 0; an empty `where` means everywhere. A picture whose longer side is above
 * `maxSidePx` is searched at that size. Sizes that do not fit give no features. */
Features findFeatures(const GreyView& picture, const GreyView& where, size_t most, uint32_t maxSidePx);

struct FeatureMatch {
    uint32_t a = 0, b = 0;  // index in each picture
};

/** Pairs of features that are each other's most similar and clearly more similar than the next. */
std::vector<FeatureMatch> matchFeatures(const Features& a, const Features& b);

/** Undistorted pixels of features: those that a pinhole with the same intrinsics would show. */
std::vector<Vec2d> pinholePixels(std::span<const Vec2d> stored, const Camerad& camera, const LensDistortion& lens);

}  // namespace dpl
