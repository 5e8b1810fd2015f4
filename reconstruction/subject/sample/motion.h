// SPDX-License-Identifier: Apache-2.0
// The subject's motion in front of the camera: a smooth sequence of actions on the 55-joint skeleton.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "reconstruction/subject/sample/hand_motion.h"
#include "reconstruction/subject/sample/head_shake.h"
#include "reconstruction/subject/sample/skinning.h"

namespace dpl {

/** Turns `joint` by `axisAngle` (radians, axes parallel to the world at rest): eased in, held and eased out. */
struct Action {
    uint8_t joint;
    Vec3d axisAngle;
    double startS, riseS, holdS, fallS;
};

class SampleMotion {
public:
    /** Arm raises, elbow flexion, leg raises, turns and a torso twist within `durationS`. Amplitudes vary by up to 8 % with the seed.
     *  `fingers`: the hands make gestures (HandMotion) in place of a slight curl. `headShake`: the head shakes too (HeadShake). */
    static SampleMotion dynamicSequence(uint64_t seed, double durationS, bool fingers = false, bool headShake = false);

    /** Twice continuously differentiable in time. The rest pose before 0. */
    TruthPose pose(double timeS) const;
    double durationS() const { return durationS_; }

private:
    std::vector<Action> actions_;
    std::vector<Vec3d> swayPhase_;
    std::optional<HandMotion> hands_;
    std::optional<HeadShake> shake_;
    double durationS_ = 0;
};

/** The A-pose with the random sway of static shot `index`: up to 9 mm, and up to about two degrees per axis. `fingers`: with
 *  the subject's own hands (stillHand) in place of the body's. */
TruthPose staticPose(uint64_t seed, uint32_t index, bool fingers = false);

}  // namespace dpl
