// SPDX-License-Identifier: Apache-2.0
// The still pictures as if the subject had not swayed: cameras relative to one still pose.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** One still picture of the training split. The camera is metric. Mask (person ≥ 128) and labels have the camera's size. */
struct GarmentView {
    Camerad camera;
    ImageGrey8 mask;
    ImageGrey8 labels;  // label values of the scan; empty when the frame has none
    Pose pose;          // for the rig, including this frame's sway
};

/** The pose of the first view, and for each view its camera seen from the subject in that pose. Views of one still subject differ by the
 *  transform of the root joint only; differences of other joints are ignored. */
struct StillViews {
    Pose pose;
    std::vector<Camerad> cameras;
};

/** `views` must not be empty, and their poses must have passed checkPose(). */
StillViews compensateSway(std::span<const JointData> joints, std::span<const GarmentView> views);

}  // namespace dpl
