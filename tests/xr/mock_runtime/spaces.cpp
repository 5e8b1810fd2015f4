// SPDX-License-Identifier: Apache-2.0
// Where things are: reference spaces, controllers, views. The world is the stage.
#include <algorithm>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"
#include "tests/xr/mock_runtime/pose.h"

namespace dpl::mockxr {
namespace {

bool offered(XrReferenceSpaceType type) {
    if (type == kLocalFloor) return runtime().enabled(kLocalFloorExtension);
    const auto& types = runtime().settings.referenceSpaces;
    return std::find(types.begin(), types.end(), type) != types.end();
}

/** The hand whose binding an action has at present: 0, 1, or -1. */
int boundHand(const Space& space) {
    return runtime().settings.interactionProfile.empty() ? -1 : space.hand;
}

/** Empty: not tracked. */
std::optional<XrPosef> worldFromSpace(const Space& space, XrTime time) {
    const Runtime& r = runtime();
    if (space.action) {
        const int hand = boundHand(space);
        if (hand < 0 || !r.settings.hands[hand].held) return std::nullopt;
        const auto& bindings = r.instance->bindings.at(space.action);
        const auto bound = bindings.find(r.settings.interactionProfile);
        if (bound == bindings.end()) return std::nullopt;
        const bool aim = bound->second.front().find("/aim/") != std::string::npos;
        return compose(aim ? r.settings.hands[hand].worldFromAim : r.settings.hands[hand].worldFromGrip, space.offset);
    }
    XrPosef worldFromOrigin = kIdentity;
    if (space.type == XR_REFERENCE_SPACE_TYPE_VIEW) worldFromOrigin = r.settings.worldFromHead(time);
    if (space.type == XR_REFERENCE_SPACE_TYPE_LOCAL) worldFromOrigin = r.worldFromLocal;
    if (space.type == kLocalFloor) worldFromOrigin = onFloor(r.worldFromLocal);
    return compose(worldFromOrigin, space.offset);
}

XrResult checkAlive(XrSpace space, XrSession session, const char* name) {
    const auto found = runtime().spaces.find(space);
    if (found == runtime().spaces.end() || found->second.session != session)
        return violated(XR_ERROR_HANDLE_INVALID, std::string(name) + " is not alive in this session");
    return XR_SUCCESS;
}

}  // namespace

namespace entry {

DPL_MOCKXR_ENTRY(xrEnumerateReferenceSpaces)(XrSession, uint32_t capacity, uint32_t* count, XrReferenceSpaceType* out) {
    std::vector<XrReferenceSpaceType> types = runtime().settings.referenceSpaces;
    if (offered(kLocalFloor)) types.push_back(kLocalFloor);
    return enumerate(capacity, count, out, types);
}

DPL_MOCKXR_ENTRY(xrCreateReferenceSpace)(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO, "createInfo"));
    if (!offered(info->referenceSpaceType))
        return violated(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "the system does not have that reference space");
    DPL_MOCKXR_TRY(checkPose(info->poseInReferenceSpace, "poseInReferenceSpace"));
    *space = runtime().newHandle<XrSpace>();
    runtime().spaces[*space] = {session, info->referenceSpaceType, XR_NULL_HANDLE, 0, info->poseInReferenceSpace};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetReferenceSpaceBoundsRect)(XrSession, XrReferenceSpaceType type, XrExtent2Df* bounds) {
    if (!offered(type)) return violated(XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, "the system does not have that reference space");
    *bounds = {0, 0};
    return XR_SPACE_BOUNDS_UNAVAILABLE;
}

DPL_MOCKXR_ENTRY(xrCreateActionSpace)(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_ACTION_SPACE_CREATE_INFO, "createInfo"));
    const auto action = r.actions.find(info->action);
    if (action == r.actions.end()) return violated(XR_ERROR_HANDLE_INVALID, "the action is not alive");
    if (action->second.type != XR_ACTION_TYPE_POSE_INPUT) return violated(XR_ERROR_ACTION_TYPE_MISMATCH, "the action is no pose");
    DPL_MOCKXR_TRY(checkPose(info->poseInActionSpace, "poseInActionSpace"));
    int hand = 0;
    if (info->subactionPath != XR_NULL_PATH) {
        DPL_MOCKXR_TRY(checkPath(info->subactionPath));
        const auto& allowed = action->second.subactions;
        if (std::find(allowed.begin(), allowed.end(), info->subactionPath) == allowed.end())
            return violated(XR_ERROR_PATH_UNSUPPORTED, "the action was made without that subaction path");
        hand = r.instance->paths[info->subactionPath - 1] == "/user/hand/right" ? 1 : 0;
    }
    *space = r.newHandle<XrSpace>();
    r.spaces[*space] = {session, XR_REFERENCE_SPACE_TYPE_MAX_ENUM, info->action, hand, info->poseInActionSpace};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroySpace)(XrSpace space) {
    runtime().spaces.erase(space);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrLocateSpace)(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkAlive(base, r.spaces.at(space).session, "baseSpace"));
    DPL_MOCKXR_TRY(checkTime(time));
    DPL_MOCKXR_TRY(checkStructure(location, XR_TYPE_SPACE_LOCATION, "location", {XR_TYPE_SPACE_VELOCITY}));
    const auto worldFromThis = worldFromSpace(r.spaces.at(space), time), worldFromBase = worldFromSpace(r.spaces.at(base), time);
    location->locationFlags = 0;
    location->pose = kIdentity;
    if (worldFromThis && worldFromBase) {
        location->locationFlags = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                                  XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
        location->pose = compose(inverse(*worldFromBase), *worldFromThis);
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrLocateHandJointsEXT)
(XrHandTrackerEXT handle, const XrHandJointsLocateInfoEXT* info, XrHandJointLocationsEXT* locations) {
    Runtime& r = runtime();
    const HandTracker& tracker = r.handTrackers.at(handle);
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, "locateInfo"));
    DPL_MOCKXR_TRY(checkAlive(info->baseSpace, tracker.session, "baseSpace"));
    DPL_MOCKXR_TRY(checkTime(info->time));
    DPL_MOCKXR_TRY(checkStructure(locations, XR_TYPE_HAND_JOINT_LOCATIONS_EXT, "locations", {XR_TYPE_HAND_JOINT_VELOCITIES_EXT}));
    if (locations->jointCount != XR_HAND_JOINT_COUNT_EXT || !locations->jointLocations)
        return violated(XR_ERROR_VALIDATION_FAILURE, "a hand has 26 joints");
    const auto& joints = r.settings.hands[tracker.hand].joints;
    const auto worldFromBase = worldFromSpace(r.spaces.at(info->baseSpace), info->time);
    locations->isActive = joints.size() == XR_HAND_JOINT_COUNT_EXT && worldFromBase;
    for (uint32_t j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j) {
        XrHandJointLocationEXT& out = locations->jointLocations[j];
        out = locations->isActive ? joints[j] : XrHandJointLocationEXT{};
        if (out.locationFlags) out.pose = compose(inverse(*worldFromBase), out.pose);
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrLocateBodyJointsFB)(XrBodyTrackerFB handle, const XrBodyJointsLocateInfoFB* info, XrBodyJointLocationsFB* locations) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_BODY_JOINTS_LOCATE_INFO_FB, "locateInfo"));
    DPL_MOCKXR_TRY(checkAlive(info->baseSpace, r.bodyTrackers.at(handle).session, "baseSpace"));
    DPL_MOCKXR_TRY(checkTime(info->time));
    DPL_MOCKXR_TRY(checkStructure(locations, XR_TYPE_BODY_JOINT_LOCATIONS_FB, "locations"));
    if (locations->jointCount != XR_BODY_JOINT_COUNT_FB || !locations->jointLocations)
        return violated(XR_ERROR_VALIDATION_FAILURE, "a body has 70 joints");
    const auto& joints = r.settings.body;
    const auto worldFromBase = worldFromSpace(r.spaces.at(info->baseSpace), info->time);
    locations->isActive = joints.size() == XR_BODY_JOINT_COUNT_FB && worldFromBase;
    locations->confidence = locations->isActive ? 1.0f : 0.0f;
    locations->skeletonChangedCount = r.settings.skeletonChanges;
    locations->time = info->time;
    for (uint32_t j = 0; j < XR_BODY_JOINT_COUNT_FB; ++j) {
        XrBodyJointLocationFB& out = locations->jointLocations[j];
        out = locations->isActive ? joints[j] : XrBodyJointLocationFB{};
        if (out.locationFlags) out.pose = compose(inverse(*worldFromBase), out.pose);
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrLocateViews)
(XrSession session, const XrViewLocateInfo* info, XrViewState* state, uint32_t capacity, uint32_t* count, XrView* out) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_VIEW_LOCATE_INFO, "viewLocateInfo"));
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_VIEW_STATE, "viewState"));
    DPL_MOCKXR_TRY(checkConfiguration(info->viewConfigurationType));
    DPL_MOCKXR_TRY(checkTime(info->displayTime));
    DPL_MOCKXR_TRY(checkAlive(info->space, session, "the space"));
    const auto worldFromBase = worldFromSpace(r.spaces.at(info->space), info->displayTime);
    state->viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_TRACKED_BIT |
                            XR_VIEW_STATE_POSITION_TRACKED_BIT;
    const std::vector<ViewSetting>& views = r.settings.views;
    const XrPosef baseFromHead = compose(inverse(*worldFromBase), r.settings.worldFromHead(info->displayTime));
    DPL_MOCKXR_TRY(enumerate(capacity, count, out, views.size(), [&](size_t i, XrView& view) {
        DPL_MOCKXR_TRY(checkStructure(&view, XR_TYPE_VIEW, "an element of views"));
        view.pose = compose(baseFromHead, views[i].headFromView);
        view.fov = views[i].fov;
        return XR_SUCCESS;
    }));
    if (capacity > 0 && r.settings.spoilViews) r.settings.spoilViews(info->displayTime, *state, {out, views.size()});
    return XR_SUCCESS;
}

}  // namespace entry
}  // namespace dpl::mockxr
