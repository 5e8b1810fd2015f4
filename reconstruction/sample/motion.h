// SPDX-License-Identifier: Apache-2.0
// What the subject does in front of the camera: a smooth script of named actions on the 55-joint skeleton.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruction/sample/skinning.h"

namespace dpl {

/** One action: joint `joint` turns by `axisAngle` (radians, world axes at rest), eased in, held and eased out. */
struct Action {
    uint8_t joint;
    Vec3d axisAngle;
    double startS, riseS, holdS, fallS;
};

class Motion {
public:
    /** Arm raises, elbow flexion, leg raises, turns and a torso twist, `durationS` long; amplitudes vary a little with the seed. */
    static Motion dynamicSequence(uint64_t seed, double durationS);

    /** Twice continuously differentiable in time; at rest before 0. */
    TruthPose pose(double timeS) const;
    double durationS() const { return durationS_; }

private:
    std::vector<Action> actions_;
    std::vector<Vec3d> swayPhase_;
    double durationS_ = 0;
};

/** The A-pose with the sway of static shot `index`: a few millimetres and degrees. */
TruthPose staticPose(uint64_t seed, uint32_t index);

}  // namespace dpl
