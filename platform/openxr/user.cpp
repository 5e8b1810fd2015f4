// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/user.h"

#include <algorithm>
#include <numbers>

namespace dpl::xr {
namespace {

constexpr float kPi = std::numbers::pi_v<float>, kSlackRad = 50 * kPi / 180;
constexpr float kFarthestM = 1000;        // a joint farther from the origin is a defect of the runtime
constexpr float kLeastHorizontal = 0.2f;  // of a view direction: below, its heading says nothing

}  // namespace

bool isLocated(XrSpaceLocationFlags flags, XrPosef& pose) {
    constexpr XrSpaceLocationFlags kNeeded = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    if ((flags & kNeeded) != kNeeded || !makeValid(pose)) return false;
    const XrVector3f& p = pose.position;
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kFarthestM;
}

User moved(const XrPosef& aFromB, const User& user) {
    User out = user;
    out.head = aFromB * user.head;
    for (Hand& hand : out.hands)
        for (XrPosef& joint : hand.joints) joint = aFromB * joint;
    for (XrPosef& joint : out.body.joints) joint = aFromB * joint;
    return out;
}

XrPosef mirrored(const Mirror& mirror, const XrPosef& pose) {
    const XrVector3f &n = mirror.normal, &at = mirror.point, &p = pose.position;
    const float twice = 2 * (n.x * (p.x - at.x) + n.y * (p.y - at.y) + n.z * (p.z - at.z));
    // A reflection is a half turn about the normal times -1. The two reflections, in the world and of the pose's own x, make a rotation.
    return {XrQuaternionf{n.x, n.y, n.z, 0} * pose.orientation * XrQuaternionf{1, 0, 0, 0},
            {p.x - twice * n.x, p.y - twice * n.y, p.z - twice * n.z}};
}

User mirrored(const Mirror& mirror, const User& user) {
    User out;
    out.head = mirrored(mirror, user.head);
    for (int side = 0; side < 2; ++side) {
        const Hand& from = user.hands[1 - side];
        out.hands[side].located = from.located;
        for (int j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j) out.hands[side].joints[j] = mirrored(mirror, from.joints[j]);
    }
    return out;
}

XrPosef Stance::of(const User& user) {
    const XrVector3f ahead = rotate(user.head.orientation, {0, 0, -1});
    if (std::hypot(ahead.x, ahead.z) >= kLeastHorizontal) {
        const float heading = std::atan2(ahead.x, ahead.z);
        if (!known_) yawRad_ = heading;
        known_ = true;
        const float turned = std::remainder(heading - yawRad_, 2 * kPi);
        yawRad_ += turned - std::clamp(turned, -kSlackRad, kSlackRad);
    }
    return {{0, std::sin(yawRad_ / 2), 0, std::cos(yawRad_ / 2)}, {user.head.position.x, 0, user.head.position.z}};
}

}  // namespace dpl::xr
