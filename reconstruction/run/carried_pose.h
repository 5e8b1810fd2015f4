// SPDX-License-Identifier: Apache-2.0
// Poses of validation and held-out frames after training, from their registered poses and from what training changed in their neighbours.
#pragma once

#include <vector>

#include "reconstruction/run/frame_table.h"
#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

/** The trained pose of each frame of the scan; null for frames that were not trained on. */
std::vector<const Pose*> trainedPoses(const FrameTable& table, const CoOptimiseResult& trained);

/** The pose of a validation or held-out frame, carried along by training; it does not use the frame's picture. Training moves poses and
 *  surface together, so the registered pose alone would not match the trained surface.
 *  Still frames: interpolated between the trained poses of the neighbours in capture order. Moving frames: the registered pose (from the
 *  frame's own keypoints), turned by what training turned the neighbours' poses. A frame without a trained neighbour of its kind keeps its
 *  registered pose. registered: one a frame of the scan; trained: of trainedPoses(). */
Pose carriedPose(const Scan& scan, const std::vector<Pose>& registered, const std::vector<const Pose*>& trained, size_t f);

/** Who may know of held-out frames: what decides about an avatar may not, not even that they come before other frames. */
enum class HeldOut : bool { Unknown, Known };

/** The poses of all frames after training: trained ones, and carriedPose() of the others. Those of moving frames know what the avatar's
 *  clothes remember of the frames before them, without held-out ones where those are unknown. motion: of that avatar. */
std::vector<Pose> posesAfterTraining(const FrameTable& table, const std::vector<Pose>& registered, const CoOptimiseResult& trained,
                                     const MotionModeData& motion, HeldOut heldOut);

}  // namespace dpl
