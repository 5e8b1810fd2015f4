// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/puppet.h"

namespace dpl::xr {
namespace {

constexpr size_t kJoints = 1 + 2 * XR_HAND_JOINT_COUNT_EXT;  // DPL_TRACK_OPENXR_HANDS: the head, the left hand, the right hand

}  // namespace

doppel::Result<Puppet> Puppet::of(const doppel::Avatar& avatar) {
    Puppet puppet;
    const auto info = avatar.info();
    if (!info) return info.error();
    if (info->jointCount == 0) return puppet;
    auto tracker = avatar.createTracker(DPL_TRACK_OPENXR_HANDS, DPL_TRACKER_RAW | DPL_TRACKER_IN_PLACE | DPL_TRACKER_OVER_POSE);
    if (!tracker) {
        if (tracker.error().code == DPL_ERROR_UNSUPPORTED) return puppet;  // no humanoid bones
        return tracker.error();
    }
    puppet.tracker_.emplace(std::move(*tracker));
    puppet.rotations_.resize(4 * kJoints), puppet.positions_.resize(3 * kJoints), puppet.confidence_.resize(kJoints);
    return puppet;
}

doppel::Status Puppet::pose(const User& user, bool withHead, double timeS) {
    if (!tracker_) return {};
    const auto put = [&](size_t joint, const XrPosef& pose, bool located) {
        const XrQuaternionf& q = pose.orientation;
        const XrVector3f& p = pose.position;
        float *turn = &rotations_[4 * joint], *place = &positions_[3 * joint];
        turn[0] = q.x, turn[1] = q.y, turn[2] = q.z, turn[3] = q.w;
        place[0] = p.x, place[1] = p.y, place[2] = p.z;
        confidence_[joint] = located ? 1.0f : 0.0f;
    };
    put(0, user.head, withHead);
    for (size_t side = 0; side < 2; ++side)
        for (uint32_t j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j)
            put(1 + side * XR_HAND_JOINT_COUNT_EXT + j, user.hands[side].joints[j], user.hands[side].has(j));
    const auto timeNs = int64_t(timeS * 1e9);
    // A frame whose hands are swapped is dropped; the avatar goes on as if they were not located.
    if (auto given = tracker_->frame(timeNs, rotations_, positions_, confidence_); !given && given.error().code != DPL_ERROR_CORRUPT_DATA)
        return given;
    const auto shown = tracker_->setPose(timeNs);
    if (!shown) return shown.error();
    return {};
}

}  // namespace dpl::xr
