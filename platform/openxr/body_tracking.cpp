// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/body_tracking.h"

namespace dpl::xr {

void BodyTracking::stop() {
    const auto destroy = runtime_.function<PFN_xrDestroyBodyTrackerFB>("xrDestroyBodyTrackerFB");
    if (tracker_ && destroy) destroy(tracker_);
    tracker_ = XR_NULL_HANDLE;
}

Status BodyTracking::start(Calls& calls, XrSession session) {
    const auto create = runtime_.function<PFN_xrCreateBodyTrackerFB>("xrCreateBodyTrackerFB");
    locate_ = runtime_.function<PFN_xrLocateBodyJointsFB>("xrLocateBodyJointsFB");
    skeleton_ = runtime_.function<PFN_xrGetBodySkeletonFB>("xrGetBodySkeletonFB");
    if (!create || !locate_ || !skeleton_)
        return Error{DPL_ERROR_UNSUPPORTED, "the runtime offers XR_FB_body_tracking but not its functions"};
    XrBodyTrackerCreateInfoFB info{XR_TYPE_BODY_TRACKER_CREATE_INFO_FB, nullptr, XR_BODY_JOINT_SET_DEFAULT_FB};
    Status made = calls.check(create(session, &info, &tracker_), "xrCreateBodyTrackerFB");
    if (!made) tracker_ = XR_NULL_HANDLE;
    return made;
}

Status BodyTracking::readSkeleton(Calls& calls_, Body& body) const {
    XrBodySkeletonJointFB joints[XR_BODY_JOINT_COUNT_FB]{};
    XrBodySkeletonFB skeleton{XR_TYPE_BODY_SKELETON_FB, nullptr, XR_BODY_JOINT_COUNT_FB, joints};
    DPL_XR_OK(calls_.check(skeleton_(tracker_, &skeleton), "xrGetBodySkeletonFB"));
    std::bitset<XR_BODY_JOINT_COUNT_FB> told;
    for (const XrBodySkeletonJointFB& joint : joints) {
        if (joint.joint < 0 || joint.joint >= int32_t(XR_BODY_JOINT_COUNT_FB) || told[size_t(joint.joint)]) continue;
        XrPosef pose = joint.pose;
        if (!makeValid(pose)) continue;
        told.set(size_t(joint.joint));
        body.rest[joint.joint] = pose;
    }
    if (!told.all()) return Error{DPL_ERROR_DEVICE, "the runtime tells no whole skeleton of the body"};
    ++body.skeleton;
    return {};
}

Status BodyTracking::locate(Calls& calls_, XrSpace world, XrTime time, Body& body) {
    body.located.reset();
    if (!tracker_) return {};
    const XrBodyJointsLocateInfoFB info{XR_TYPE_BODY_JOINTS_LOCATE_INFO_FB, nullptr, world, time};
    XrBodyJointLocationFB joints[XR_BODY_JOINT_COUNT_FB]{};
    XrBodyJointLocationsFB locations{XR_TYPE_BODY_JOINT_LOCATIONS_FB};
    locations.jointCount = XR_BODY_JOINT_COUNT_FB;
    locations.jointLocations = joints;
    DPL_XR_OK(calls_.check(locate_(tracker_, &info, &locations), "xrLocateBodyJointsFB"));
    if (!locations.isActive) return {};
    if (known_ != locations.skeletonChangedCount) {
        DPL_XR_OK(readSkeleton(calls_, body));
        known_ = locations.skeletonChangedCount;
    }
    for (uint32_t j = 0; j < XR_BODY_JOINT_COUNT_FB; ++j) {
        body.joints[j] = joints[j].pose;
        body.located[j] = isLocated(joints[j].locationFlags, body.joints[j]);
    }
    return {};
}

}  // namespace dpl::xr
