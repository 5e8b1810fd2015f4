// SPDX-License-Identifier: Apache-2.0
// Rotations of bones from the 33 points of MediaPipe Pose. Points tell directions; what they leave open (twists) follows from the planes in
// which elbows and knees bend, and where limbs are straight from how they hang.
#pragma once

#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

constexpr size_t kPosePoints = 33;

/** A T-pose that faces +Z, metres, 1.7 m high: a position for each bone of humanoidBoneNames(). Directions are what counts in it. */
std::span<const Vec3f> standardRest();

/** What points tell of the bones of humanoidBoneNames(). */
struct PointBones {
    std::vector<Quatf> rotations;  // D: world rotation since standardRest()
    std::vector<uint8_t> tracked;  // by bone
    bool swapped = false;          // left and right contradict each other: face and feet look behind, or hips and shoulders do
};

/** points: in a space with +Y up, metres. tracked: by point. `out` is reused. */
void bonesFromPoints(std::span<const Vec3f> points, std::span<const uint8_t> tracked, PointBones& out);

}  // namespace dpl
