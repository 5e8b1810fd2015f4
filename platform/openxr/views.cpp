// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/views.h"

#include <doppel/doppel_convert.h>

#include "platform/openxr/poses.h"

namespace dpl::xr {
namespace {

/** What dplCameraFromAngles takes. */
bool isValid(const XrFovf& fov) {
    constexpr float kMost = 1.569f;  // 89.9 degrees
    for (const float angle : {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown})
        if (!(std::abs(angle) <= kMost)) return false;
    return fov.angleLeft < fov.angleRight && fov.angleDown < fov.angleUp;
}

}  // namespace

Result<const char*> locateViews(Calls& calls_, XrSession session, const Display& display, XrSpace world, XrTime time,
                                XrView (&views)[kMaxViews]) {
    for (XrView& view : views) view = {XR_TYPE_VIEW};
    XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO};
    info.viewConfigurationType = display.views;
    info.displayTime = time;
    info.space = world;
    XrViewState state{XR_TYPE_VIEW_STATE};
    uint32_t count = 0;
    DPL_XR(xrLocateViews, session, &info, &state, kMaxViews, &count, views);
    constexpr XrViewStateFlags kNeeded = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
    if (count != display.viewCount) return "the runtime located another number of views than it has";
    if ((state.viewStateFlags & kNeeded) != kNeeded) return "the head is not tracked";
    for (uint32_t i = 0; i < count; ++i) {
        if (!makeValid(views[i].pose)) return "the runtime gave a view a pose that is not finite or no rotation";
        if (!isValid(views[i].fov)) return "the runtime gave a view a field of view that is empty, mirrored or wider than 179.8 degrees";
    }
    return static_cast<const char*>(nullptr);
}

XrPosef headOf(const XrView* views, uint32_t count) {
    XrPosef head = views[0].pose;
    if (count < 2) return head;
    const XrPosef& other = views[1].pose;
    XrVector3f& p = head.position;
    p = {0.5f * (p.x + other.position.x), 0.5f * (p.y + other.position.y), 0.5f * (p.z + other.position.z)};
    head.orientation = partOf(other.orientation * conjugate(head.orientation), 0.5f) * head.orientation;
    return head;
}

Status camerasOf(const XrView* views, const GroupImages& images, GroupFrame& frame) {
    frame.views = images.views;
    for (uint32_t v = 0; v < images.views; ++v) {
        DplCamera& camera = frame.cameras[v];
        camera = {};
        camera.structSize = sizeof camera;
        const XrPosef& pose = views[v].pose;
        DPL_XR_OK(doppel::status(
            dplCameraFromAngles(&pose.orientation.x, &pose.position.x, &views[v].fov.angleLeft, images.widthPx, images.heightPx, &camera)));
    }
    return {};
}

}  // namespace dpl::xr
