// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/world.h"

#include <algorithm>

#include "platform/openxr/enumerate.h"

namespace dpl::xr {
namespace {

constexpr float kEyeHeightM = 1.6f;  // where the runtime does not know the floor

}  // namespace

Status World::create(const Runtime& runtime, Calls& calls_, XrSession session) {
    std::vector<XrReferenceSpaceType> types;
    DPL_XR_OK(calls_.check(
        enumerate(types, XrReferenceSpaceType{},
                  [&](auto capacity, auto count, auto out) { return xrEnumerateReferenceSpaces(session, capacity, count, out); }),
        "xrEnumerateReferenceSpaces"));
    const auto offered = [&](XrReferenceSpaceType type) { return std::find(types.begin(), types.end(), type) != types.end(); };
    if (runtime.extensions().localFloor && offered(XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT))
        type_ = XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT;
    else if (offered(XR_REFERENCE_SPACE_TYPE_STAGE))
        type_ = XR_REFERENCE_SPACE_TYPE_STAGE;
    else if (offered(XR_REFERENCE_SPACE_TYPE_LOCAL))
        inReferenceSpace_.position.y = -kEyeHeightM;
    else
        return Error{DPL_ERROR_UNSUPPORTED, "the runtime has no space that stays where it is: neither LOCAL nor STAGE; update it"};
    XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO};
    info.referenceSpaceType = type_;
    info.poseInReferenceSpace = inReferenceSpace_;
    DPL_XR(xrCreateReferenceSpace, session, &info, &space_);
    return {};
}

void World::changePending(const XrEventDataReferenceSpaceChangePending& event) {
    XrPosef pose = event.poseInPreviousSpace;
    if (event.referenceSpaceType != type_ || !event.poseValid || !makeValid(pose)) return;
    const XrPosef moved = inverse(inReferenceSpace_) * pose * inReferenceSpace_;
    move_ = move_ ? *move_ * moved : moved;
    moveTime_ = event.changeTime;
}

std::optional<XrPosef> World::takeMove(XrTime displayTime) {
    if (!move_ || displayTime < moveTime_) return std::nullopt;
    return std::exchange(move_, std::nullopt);
}

}  // namespace dpl::xr
