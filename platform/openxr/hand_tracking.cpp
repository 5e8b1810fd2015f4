// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/hand_tracking.h"

namespace dpl::xr {
void HandTracking::stop() {
    const auto destroy = runtime_.function<PFN_xrDestroyHandTrackerEXT>("xrDestroyHandTrackerEXT");
    for (XrHandTrackerEXT& tracker : trackers_) {
        if (tracker && destroy) destroy(tracker);
        tracker = XR_NULL_HANDLE;
    }
}

Status HandTracking::start(Calls& calls, XrSession session) {
    const auto create = runtime_.function<PFN_xrCreateHandTrackerEXT>("xrCreateHandTrackerEXT");
    locate_ = runtime_.function<PFN_xrLocateHandJointsEXT>("xrLocateHandJointsEXT");
    if (!create || !locate_) return Error{DPL_ERROR_UNSUPPORTED, "the runtime offers XR_EXT_hand_tracking but not its functions"};
    constexpr XrHandEXT kSides[] = {XR_HAND_LEFT_EXT, XR_HAND_RIGHT_EXT};
    for (int side = 0; side < 2; ++side) {
        XrHandTrackerCreateInfoEXT info{XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT};
        info.hand = kSides[side];
        info.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
        Status made = calls.check(create(session, &info, &trackers_[side]), "xrCreateHandTrackerEXT");
        if (made) continue;
        trackers_[side] = XR_NULL_HANDLE;
        stop();
        return made;
    }
    return {};
}

Status HandTracking::locate(Calls& calls_, XrSpace world, XrTime time, Hand (&hands)[2]) const {
    for (Hand& hand : hands) hand.located = 0;
    for (int side = 0; side < 2 && trackers_[side]; ++side) {
        XrHandJointsLocateInfoEXT info{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT};
        info.baseSpace = world;
        info.time = time;
        XrHandJointLocationEXT joints[XR_HAND_JOINT_COUNT_EXT]{};
        XrHandJointLocationsEXT locations{XR_TYPE_HAND_JOINT_LOCATIONS_EXT};
        locations.jointCount = XR_HAND_JOINT_COUNT_EXT;
        locations.jointLocations = joints;
        DPL_XR_OK(calls_.check(locate_(trackers_[side], &info, &locations), "xrLocateHandJointsEXT"));
        if (!locations.isActive) continue;
        Hand& hand = hands[side];
        for (uint32_t j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j) {
            hand.joints[j] = joints[j].pose;
            if (isLocated(joints[j].locationFlags, hand.joints[j])) hand.located |= 1u << j;
        }
    }
    return {};
}

}  // namespace dpl::xr
