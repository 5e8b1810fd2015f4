// SPDX-License-Identifier: Apache-2.0
// Neck, head and eyes that look at a point. Formulas: docs/reference/mixing.md.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** The joints of a rig that look. */
struct GazeJoints {
    size_t head = 0;
    std::optional<size_t> neck;                 // above the head
    std::array<std::optional<size_t>, 2> eyes;  // left, right

    /** Unsupported: no joint is known as the head; the text lists the joints. */
    static Result<GazeJoints> of(std::span<const JointData> joints);
};

/** Most that a part turns away from straight ahead, rad: x to the left and right, y up and down. Between, the limit is an ellipse. */
constexpr Vec2f kUsualHeadLimitRad{1.05f, 0.7f};  // neck and head together, from straight ahead of the trunk
constexpr Vec2f kUsualEyeLimitRad{0.6f, 0.4f};    // from straight ahead of the head
constexpr float kLargestGazeLimitRad = 1.5708f;

/** A point nearer than this to the line from the neck to the eyes lies inside the person. From there to kGazeClearM the gaze fades in. */
constexpr double kGazeInsideM = 0.12, kGazeClearM = 0.24;

struct Gaze {
    Vec3f target{0};       // metres, avatar space
    float headWeight = 0;  // 0 to 1: the part of the way to the target that neck and head take
    float eyeWeight = 0;   // 0 to 1: the part of the way that is left which the eyes take
    Vec2f headLimitRad = kUsualHeadLimitRad, eyeLimitRad = kUsualEyeLimitRad;
};

/** Where a joint that looked along +Z at rest looks now: the shortest turn there, rad, as angles to the left and up. */
Vec2d gazeTurn(const Quatf& localRotation);

/** Turns neck, head and eyes of a pose towards a point, from where the pose has them. A function of its arguments, smooth in all of them:
 *  turns approach their limits smoothly, and from 115 degrees on the gaze fades, so that nothing flips when the target passes behind.
 *  transforms: scratch, which keeps its memory. The pose must have passed checkPose; Pose::before stays.
 *  InvalidArgument, and `pose` stays: numbers that are not finite, weights outside 0 to 1, limits that are not above 0 and at most 90
 *  degrees, a target inside the head or the neck. */
Status lookAt(std::span<const JointData> joints, const GazeJoints& who, const Gaze& gaze, Pose& pose, std::vector<Mat3x4f>& transforms);

}  // namespace dpl
