// SPDX-License-Identifier: Apache-2.0
// The levels of training frames: a frame at one resolution, cropped, as a training step reads it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/training/trainer/losses.h"

namespace dpl {

/** The poses of the moving frames, in their order. */
std::vector<Pose> movingPoses(std::span<const TrainFrame> frames);
/** The poses of the others. */
std::vector<Pose> stillPoses(std::span<const TrainFrame> frames);

/** Variance of the low-pass that avatars are trained and drawn with, in pixels² of the target at every scale. 1/12 is the variance of a
 *  pixel's square, so a drawing is close to the area average of a larger drawing. With a wider low-pass (0.3 px² is common) splats learn to
 *  undo the blur at their training size and look ragged at other sizes. */
constexpr float kTrainedKappaPx2 = 1.0f / 12;

/** A frame at one level: area-averaged, cropped to the person's box with a margin of 10 %, 8 bits a channel. */
struct LevelFrame {
    bool used = false;               // false when the mask is empty
    std::optional<TargetName> name;  // of the frames of LevelFrames
    uint32_t widthPx = 0, heightPx = 0;
    uint32_t leftPx = 0, topPx = 0;  // the crop's corner in the whole image of the level
    float scale = 1;                 // level width / full width
    float kappaPx2 = 0;
    Cameraf camera;                                                // of the crop
    std::vector<uint8_t> rgb, mask, cloth, shown, unsure, behind;  // as in PictureTarget
    float edgeMaskWeight = 1;
    uint32_t personPx = 0;

    PictureTarget target() const { return {widthPx, heightPx, rgb, mask, cloth, shown, unsure, behind, edgeMaskWeight}; }
};

/** The frame's picture, whose image, mask and labels (unless empty) have the camera's size. The error names the frame. */
Result<std::shared_ptr<const FramePicture>> checkedPicture(const TrainFrame& frame);
/** Checks that the precision, if there is one, fits a rig of so many joints. The error names the frame. */
Status checkPrecision(const TrainFrame& frame, size_t jointCount);

/** Pixels of a frame's crop at full size; 0: nobody is in its mask. */
uint64_t cropPx(const FramePicture& picture);

/** The person's pixels of the frame's picture at `scale`, as isPerson() of the mask says. clothLabels: label values that count as cloth.
 * The mask's edge (unsure_edge.h) is marked at every resolution for masks that networks found, and for a scan's own if `fullResolution`: a
 * pixel is too wide elsewhere. */
LevelFrame makeLevelFrame(const TrainFrame& frame, const FramePicture& picture, float scale, std::span<const uint8_t> clothLabels,
                          bool fullResolution);

/** The scale of a frame at the coarsest level: its short side becomes 160 px, but the scale stays in [0.1, 1]. */
float coarsestScale(const TrainFrame& frame);

}  // namespace dpl
