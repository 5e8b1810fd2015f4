// SPDX-License-Identifier: Apache-2.0
// The 55-joint skeleton of the built-in body: SMPL-X's joint list and order, VRM humanoid names, and its own A-pose positions.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

enum BuiltinJoint : uint8_t {
    kPelvis,
    kLeftHip,
    kRightHip,
    kSpine1,
    kLeftKnee,
    kRightKnee,
    kSpine2,
    kLeftAnkle,
    kRightAnkle,
    kSpine3,
    kLeftFoot,
    kRightFoot,
    kNeck,
    kLeftCollar,
    kRightCollar,
    kHead,
    kLeftShoulder,
    kRightShoulder,
    kLeftElbow,
    kRightElbow,
    kLeftWrist,
    kRightWrist,
    kJaw,
    kLeftEye,
    kRightEye,
    kLeftIndex1,
    kLeftMiddle1 = kLeftIndex1 + 3,
    kLeftPinky1 = kLeftMiddle1 + 3,
    kLeftRing1 = kLeftPinky1 + 3,
    kLeftThumb1 = kLeftRing1 + 3,
    kRightIndex1 = kLeftThumb1 + 3,
    kBuiltinJointCount = 55
};

enum Finger : uint8_t { kIndex, kMiddle, kPinky, kRing, kThumb, kFingerCount };

/** Joint `bone` (0 to 2) of a finger of the left hand. Add kRightIndex1 − kLeftIndex1 for the right hand. */
constexpr uint8_t leftFingerJoint(Finger finger, int bone) {
    return uint8_t(kLeftIndex1 + 3 * finger + bone);
}

/** The joint on the other side. Joints in the middle (spine, neck, head, jaw) map to themselves. */
uint8_t mirroredJoint(uint8_t joint);

/** 55 joints, parents first. Rest positions in metres: +Y up, facing +Z, feet on y = 0, 1.75 m tall, arms 42° below the horizontal. */
std::vector<JointData> builtinSkeleton();

/** Wrist of the left hand and unit axes: along the fingers, towards the thumb, out of the back of the hand. World frame, metres. */
struct HandFrame {
    Vec3f wrist, along, thumbward, dorsal;
    Vec3f at(float s, float w, float n) const { return wrist + along * s + thumbward * w + dorsal * n; }
};
HandFrame leftHandFrame();

/** Positions of joints 1, 2, 3 and the tip of a finger of the left hand, metres. */
std::array<Vec3f, 4> leftFingerChain(Finger finger);

/** Positions of the left foot's ankle, ball (joint left_foot) and tip of the second toe, metres. */
std::array<Vec3f, 3> leftFootChain();

}  // namespace dpl
