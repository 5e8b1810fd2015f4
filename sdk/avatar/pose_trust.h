// SPDX-License-Identifier: Apache-2.0
// How far a pose lies from the poses that an avatar was trained on. Formulas: docs/reference/correctives.md.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/pose_correctives.h"

namespace dpl {

struct PoseTrust {
    float offsets = 1;   // share of the pose correctives that is drawn, 0 to 1
    float away = 0;      // ‖k‖ / reach
    float offModes = 0;  // distance off the modes / reachOffModes
    /** One for each joint of the rig: distance of its local rotation from the mean of the training poses, over their standard deviation (of
     *  at least 3°). −1: the file does not know the joint. */
    std::vector<float> joints;
};

/** The correctives must have passed checkCorrectives and must not be empty, the pose must have passed checkPose. `trust` is reused. */
void poseTrust(const PoseCorrectiveData& correctives, const Pose& pose, PoseTrust& trust);

/** Turns each joint that the file knows back towards its mean in training, along the shortest arc, until its distance of poseTrust is at
 * most `limit`, or as far as the mean. Joints within the limit and all others keep their rotation. limit > 0. Preconditions as above. */
void holdPose(const PoseCorrectiveData& correctives, float limit, Pose& pose);

}  // namespace dpl
