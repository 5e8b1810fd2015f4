// SPDX-License-Identifier: Apache-2.0
// Training frames, and the level (resolution, crop) of them that a step reads.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstruction/capture/frame_picture.h"
#include "reconstruction/splat/losses.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** One picture with its camera and the subject's pose. Copies share the picture, which nobody changes. */
struct TrainFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Camerad camera;
    Pose pose;
    std::shared_ptr<const FramePicture> picture;  // of the camera's size
};

/** The low-pass that avatars are trained and drawn with, target pixels² at every scale: the variance of a pixel's own square. A drawing is
 *  then the area average of a larger one. With a wider low-pass (0.3 px² is common) splats learn to undo the blur at their training size
 *  and look ragged at other sizes. */
constexpr float kTrainedKappaPx2 = 1.0f / 12;

/** A frame at one level: area-averaged, cropped to the person's box + 10 %, eight bits. `used` is false when the mask is empty. */
struct LevelFrame {
    bool used = false;
    uint32_t widthPx = 0, heightPx = 0;
    uint32_t leftPx = 0, topPx = 0;  // of the crop in the level's whole image
    float scale = 1;                 // level width / full width
    float kappaPx2 = 0;
    Cameraf camera;            // of the crop
    std::vector<uint8_t> rgb;  // planar, premultiplied by the mask
    std::vector<uint8_t> mask, cloth, band;

    PictureTarget target() const { return {widthPx, heightPx, rgb, mask, cloth, band}; }
};

/** Image and mask must have the camera's size, and so must labels unless they are empty. The error names the frame. */
Status checkTrainFrame(const TrainFrame& frame);

/** The person's pixels at `scale`, colour premultiplied by the mask as isPerson() cuts it. clothLabels: label values that count as cloth.
 *  withBand: mark the one-pixel band about the mask's edge (full resolution). */
LevelFrame makeLevelFrame(const TrainFrame& frame, float scale, std::span<const uint8_t> clothLabels, bool withBand);

/** Coarsest scale of a frame: the larger of 0.1 and a short side of 160 px, at most 1. */
float coarsestScale(const TrainFrame& frame);

}  // namespace dpl
