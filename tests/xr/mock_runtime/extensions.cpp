// SPDX-License-Identifier: Apache-2.0
// Refresh rates, trackers of hands and bodies, passthrough.
#include <algorithm>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr::entry {

DPL_MOCKXR_ENTRY(xrEnumerateDisplayRefreshRatesFB)(XrSession, uint32_t capacity, uint32_t* count, float* out) {
    return enumerate(capacity, count, out, runtime().settings.refreshRatesHz);
}

DPL_MOCKXR_ENTRY(xrGetDisplayRefreshRateFB)(XrSession, float* rate) {
    *rate = runtime().refreshHz;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrRequestDisplayRefreshRateFB)(XrSession, float rate) {
    const std::vector<float>& rates = runtime().settings.refreshRatesHz;
    if (rate == 0) return XR_SUCCESS;  // the runtime chooses
    if (std::find(rates.begin(), rates.end(), rate) == rates.end())
        return violated(XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB, "the display does not have that rate");
    changeRefreshRate(rate);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreateHandTrackerEXT)(XrSession session, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* tracker) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, "createInfo"));
    if (!r.settings.tracksHands) return violated(XR_ERROR_FEATURE_UNSUPPORTED, "the system does not track hands");
    if (info->hand != XR_HAND_LEFT_EXT && info->hand != XR_HAND_RIGHT_EXT)
        return violated(XR_ERROR_VALIDATION_FAILURE, "the hand is neither the left nor the right one");
    if (info->handJointSet != XR_HAND_JOINT_SET_DEFAULT_EXT) return violated(XR_ERROR_VALIDATION_FAILURE, "there is no such set of joints");
    *tracker = r.newHandle<XrHandTrackerEXT>();
    r.handTrackers[*tracker] = {session, info->hand == XR_HAND_LEFT_EXT ? 0 : 1};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyHandTrackerEXT)(XrHandTrackerEXT tracker) {
    runtime().handTrackers.erase(tracker);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreateBodyTrackerFB)(XrSession session, const XrBodyTrackerCreateInfoFB* info, XrBodyTrackerFB* tracker) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_BODY_TRACKER_CREATE_INFO_FB, "createInfo"));
    if (!r.settings.tracksBodies) return violated(XR_ERROR_FEATURE_UNSUPPORTED, "the system does not track bodies");
    if (info->bodyJointSet != XR_BODY_JOINT_SET_DEFAULT_FB) return violated(XR_ERROR_VALIDATION_FAILURE, "there is no such set of joints");
    *tracker = r.newHandle<XrBodyTrackerFB>();
    r.bodyTrackers[*tracker] = {session};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyBodyTrackerFB)(XrBodyTrackerFB tracker) {
    runtime().bodyTrackers.erase(tracker);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetBodySkeletonFB)(XrBodyTrackerFB, XrBodySkeletonFB* skeleton) {
    DPL_MOCKXR_TRY(checkStructure(skeleton, XR_TYPE_BODY_SKELETON_FB, "skeleton"));
    if (skeleton->jointCount != XR_BODY_JOINT_COUNT_FB || !skeleton->joints)
        return violated(XR_ERROR_VALIDATION_FAILURE, "a body has 70 joints");
    const auto& told = runtime().settings.skeleton;
    std::copy_n(told.begin(), std::min<size_t>(told.size(), XR_BODY_JOINT_COUNT_FB), skeleton->joints);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreatePassthroughFB)(XrSession session, const XrPassthroughCreateInfoFB* info, XrPassthroughFB* passthrough) {
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_PASSTHROUGH_CREATE_INFO_FB, "createInfo"));
    *passthrough = runtime().newHandle<XrPassthroughFB>();
    runtime().passthroughs[*passthrough] = {session};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyPassthroughFB)(XrPassthroughFB passthrough) {
    runtime().passthroughs.erase(passthrough);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrPassthroughStartFB)(XrPassthroughFB) {
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreatePassthroughLayerFB)(XrSession session, const XrPassthroughLayerCreateInfoFB* info, XrPassthroughLayerFB* layer) {
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_PASSTHROUGH_LAYER_CREATE_INFO_FB, "createInfo"));
    if (!runtime().passthroughs.count(info->passthrough)) return violated(XR_ERROR_HANDLE_INVALID, "the passthrough is not alive");
    *layer = runtime().newHandle<XrPassthroughLayerFB>();
    runtime().passthroughLayers[*layer] = {session};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyPassthroughLayerFB)(XrPassthroughLayerFB layer) {
    runtime().passthroughLayers.erase(layer);
    return XR_SUCCESS;
}

}  // namespace dpl::mockxr::entry
