// SPDX-License-Identifier: Apache-2.0
// Poses of frames that were not trained on, from their own keypoints and the training's change of their neighbours' poses.
#pragma once

#include <vector>

#include "reconstruction/run/frame_table.h"
#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

/** The trained pose of each frame of the scan; null for frames that were not trained on. */
std::vector<const Pose*> trainedPoses(const FrameTable& table, const CoOptimiseResult& trained);

/** The registered pose of a validation or held-out frame; it does not use the frame's picture. Training moves poses and surface together,
 *  so the registered pose alone would not match the trained surface.
 *  Still frames: interpolated between the trained poses of the neighbours in capture order. Moving frames: the registered pose (from the
 *  frame's own keypoints), corrected by the change of the neighbours' poses in training. `untrained`: all poses before training. */
Pose registeredPose(const Scan& scan, const std::vector<Pose>& untrained, const std::vector<const Pose*>& trained, size_t f);

}  // namespace dpl
