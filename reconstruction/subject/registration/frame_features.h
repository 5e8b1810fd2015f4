// SPDX-License-Identifier: Apache-2.0
// What registration compares of a picture: local contrast at one blur, and distances to the outlines of the person and of rigid labels.
// Private to reconstruction/subject/registration.
#pragma once

#include <map>
#include <vector>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/subject/body/fit_silhouette.h"

namespace dpl {

/** The picture at most maxSidePx wide and high. A picture that fits is copied. */
FramePicture reducedPicture(const FramePicture& picture, uint32_t maxSidePx);

/** Local contrast of a picture: its blur inside the mask minus a blur three times as wide. Shade that changes slowly drops out. */
struct ContrastImage {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<Vec3f> values;    // colours in 0 … 1; continued outside the mask, fading to 0
    std::vector<uint8_t> inside;  // 1: person

    bool isInside(const Vec2d& px) const { return inside[size_t(px.y) * widthPx + size_t(px.x)] != 0; }
    /** Bilinear value and its derivatives at a pixel position. False at the border. */
    bool sample(const Vec2d& px, Vec3d& value, Vec3d& dx, Vec3d& dy) const;
};
ContrastImage contrastImage(const FramePicture& picture, double blurPx);

/** Signed distances to outlines, negative inside. A missing entry: the picture shows no such outline. */
struct FrameOutlines {
    std::map<uint8_t, MaskDistance> byLabel;  // key 0: the person
};
FrameOutlines frameOutlines(const FramePicture& picture, std::span<const uint8_t> labels, uint32_t maxSidePx);

}  // namespace dpl
