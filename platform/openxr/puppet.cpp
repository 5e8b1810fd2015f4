// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/puppet.h"

namespace dpl::xr {
namespace {

constexpr size_t kJoints = 1 + 2 * XR_HAND_JOINT_COUNT_EXT;  // DPL_TRACK_OPENXR_HANDS: the head, the left hand, the right hand
constexpr uint32_t kFlags = DPL_TRACKER_RAW | DPL_TRACKER_IN_PLACE | DPL_TRACKER_OVER_POSE;

}  // namespace

void Puppet::Follower::resize(size_t joints) {
    rotations.resize(4 * joints), positions.resize(3 * joints), confidence.resize(joints);
}

void Puppet::Follower::put(size_t joint, const XrPosef& pose, bool located) {
    const XrQuaternionf& q = pose.orientation;
    const XrVector3f& p = pose.position;
    float *turn = &rotations[4 * joint], *place = &positions[3 * joint];
    turn[0] = q.x, turn[1] = q.y, turn[2] = q.z, turn[3] = q.w;
    place[0] = p.x, place[1] = p.y, place[2] = p.z;
    confidence[joint] = located ? 1.0f : 0.0f;
}

doppel::Status Puppet::Follower::pose(int64_t timeNs) {
    // A frame whose sides are swapped is dropped; the avatar goes on as if nothing were located.
    if (auto given = tracker->frame(timeNs, rotations, positions, confidence); !given && given.error().code != DPL_ERROR_CORRUPT_DATA)
        return given;
    const auto shown = tracker->setPose(timeNs);
    if (!shown) return shown.error();
    return {};
}

doppel::Result<Puppet> Puppet::of(const doppel::Avatar& avatar) {
    Puppet puppet;
    const auto info = avatar.info();
    if (!info) return info.error();
    if (info->jointCount == 0) return puppet;
    auto tracker = avatar.createTracker(DPL_TRACK_OPENXR_HANDS, kFlags);
    if (!tracker) {
        if (tracker.error().code == DPL_ERROR_UNSUPPORTED) return puppet;  // no humanoid bones
        return tracker.error();
    }
    puppet.avatar_ = avatar.handle();
    puppet.hands_.tracker.emplace(std::move(*tracker));
    puppet.hands_.resize(kJoints);
    puppet.body_.resize(XR_BODY_JOINT_COUNT_FB);
    return puppet;
}

/** Makes the tracker of a skeleton that the runtime has just told. One that is none, such as a person who lies, is not followed. */
doppel::Status Puppet::followSkeleton(const Body& body) {
    skeleton_ = body.skeleton;
    for (uint32_t j = 0; j < XR_BODY_JOINT_COUNT_FB; ++j) body_.put(j, body.rest[j], true);
    body_.tracker.reset();
    DplTrackerInfo info{};
    info.structSize = sizeof info;
    info.format = DPL_TRACK_FB_BODY;
    info.flags = kFlags;
    info.restCount = XR_BODY_JOINT_COUNT_FB;
    info.restRotations = body_.rotations.data(), info.restPositions = body_.positions.data();
    DplTracker made = nullptr;
    if (const DplResult result = dplCreateTracker(avatar_, &info, &made); result != DPL_OK)
        return result == DPL_ERROR_CORRUPT_DATA ? doppel::Status{} : doppel::lastError(result);
    body_.tracker.emplace(made);
    return {};
}

doppel::Status Puppet::pose(const User& user, bool withHead, double timeS) {
    if (!drives()) return {};
    hands_.put(0, user.head, withHead);
    for (size_t side = 0; side < 2; ++side)
        for (uint32_t j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j)
            hands_.put(1 + side * XR_HAND_JOINT_COUNT_EXT + j, user.hands[side].joints[j], user.hands[side].has(j));
    const auto timeNs = int64_t(timeS * 1e9);
    if (auto posed = hands_.pose(timeNs); !posed) return posed;
    // Over it, so that a body that is lost passes over to hands, and these to the pose beneath.
    if (user.body.skeleton != skeleton_)
        if (auto made = followSkeleton(user.body); !made) return made;
    if (!body_.tracker) return {};
    for (uint32_t j = 0; j < XR_BODY_JOINT_COUNT_FB; ++j) body_.put(j, user.body.joints[j], user.body.located[j]);
    return body_.pose(timeNs);
}

}  // namespace dpl::xr
