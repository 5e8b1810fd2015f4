// SPDX-License-Identifier: Apache-2.0
// Training frames and what a step reads of them: one resolution level, cropped to the person.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/capture/scan.h"
#include "reconstruction/splat/losses.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** One observed picture with its camera and the subject's pose, decoded once. `labels` may be empty. */
struct TrainFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Camerad camera;
    Pose pose;
    ImageRgb8 image;
    ImageGrey8 mask;
    ImageGrey8 labels;
};

/** The low-pass that avatars are trained and drawn with, target pixels² at every scale: the variance of a pixel's own square. Drawing at
 * one size is then the area average of drawing at a larger one; with more (0.3 px² is common) splats learn to undo the blur of their
 * training size, and look ragged at any other. */
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

/** Image and mask must have the camera's size; labels too when there are any. Names the frame when not. */
Status checkTrainFrame(const TrainFrame& frame);

/** clothLabels: label values that count as cloth. withBand: mark the one-pixel band about the mask's edge (full resolution). */
LevelFrame makeLevelFrame(const TrainFrame& frame, float scale, std::span<const uint8_t> clothLabels, bool withBand);

/** Coarsest scale of a frame: the larger of 0.1 and a short side of 160 px, at most 1. */
float coarsestScale(const TrainFrame& frame);

}  // namespace dpl
