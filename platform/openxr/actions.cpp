// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/actions.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "platform/openxr/poses.h"

namespace dpl::xr {
namespace {

struct Profile {
    const char* path;
    const char* select;
    const char* turn;  // null: the controller has no stick
};

constexpr Profile kProfiles[] = {
    {"/interaction_profiles/khr/simple_controller", "/input/select/click", nullptr},
    {"/interaction_profiles/oculus/touch_controller", "/input/trigger/value", "/input/thumbstick/x"},
    {"/interaction_profiles/valve/index_controller", "/input/trigger/value", "/input/thumbstick/x"},
    {"/interaction_profiles/microsoft/motion_controller", "/input/trigger/value", "/input/thumbstick/x"},
    {"/interaction_profiles/htc/vive_controller", "/input/trigger/value", "/input/trackpad/x"},
};
constexpr const char* kHands[] = {"/user/hand/left", "/user/hand/right"};

XrActionStateGetInfo stateInfo(XrAction action, XrPath hand) {
    XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO};
    info.action = action;
    info.subactionPath = hand;
    return info;
}

}  // namespace

Actions::~Actions() {
    detach();
    if (set_) xrDestroyActionSet(set_);  // and with it its actions
}

Status Actions::create(Calls& calls_) {
    for (int hand = 0; hand < 2; ++hand) DPL_XR(xrStringToPath, runtime_.instance(), kHands[hand], &hands_[hand]);
    XrActionSetCreateInfo set{XR_TYPE_ACTION_SET_CREATE_INFO};
    std::strcpy(set.actionSetName, "avatar");
    std::strcpy(set.localizedActionSetName, "Avatar");
    DPL_XR(xrCreateActionSet, runtime_.instance(), &set, &set_);
    const struct {
        XrAction* action;
        XrActionType type;
        const char *name, *shown;
    } actions[] = {{&aim_, XR_ACTION_TYPE_POSE_INPUT, "aim", "Aim"},
                   {&select_, XR_ACTION_TYPE_BOOLEAN_INPUT, "place", "Place the avatar"},
                   {&turn_, XR_ACTION_TYPE_FLOAT_INPUT, "turn", "Turn the avatar"}};
    for (const auto& action : actions) {
        XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
        info.actionType = action.type;
        std::strcpy(info.actionName, action.name);
        std::strcpy(info.localizedActionName, action.shown);
        info.countSubactionPaths = 2;
        info.subactionPaths = hands_;
        DPL_XR(xrCreateAction, set_, &info, action.action);
    }
    return suggest(calls_);
}

Status Actions::suggest(Calls& calls_) {
    bool any = false, complete = true;
    const auto path = [&](const std::string& text) {
        XrPath made = XR_NULL_PATH;
        complete &= XR_SUCCEEDED(xrStringToPath(runtime_.instance(), text.c_str(), &made));
        return made;
    };
    Status last = Error{DPL_ERROR_UNSUPPORTED, "the runtime takes no paths of controllers"};
    for (const Profile& profile : kProfiles) {
        std::vector<XrActionSuggestedBinding> bindings;
        for (const std::string hand : kHands) {
            bindings.push_back({aim_, path(hand + "/input/aim/pose")});
            bindings.push_back({select_, path(hand + profile.select)});
            if (profile.turn) bindings.push_back({turn_, path(hand + profile.turn)});
        }
        const XrPath named = path(profile.path);
        if (!std::exchange(complete, true)) continue;
        XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING};
        info.interactionProfile = named;
        info.countSuggestedBindings = uint32_t(bindings.size());
        info.suggestedBindings = bindings.data();
        last = calls_.check(xrSuggestInteractionProfileBindings(runtime_.instance(), &info), "xrSuggestInteractionProfileBindings");
        any |= bool(last);  // a runtime need not know every controller
    }
    return any ? Status{} : last;
}

Status Actions::attach(Calls& calls_, XrSession session) {
    XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO};
    info.countActionSets = 1;
    info.actionSets = &set_;
    DPL_XR(xrAttachSessionActionSets, session, &info);
    for (int hand = 0; hand < 2; ++hand) {
        XrActionSpaceCreateInfo space{XR_TYPE_ACTION_SPACE_CREATE_INFO};
        space.action = aim_;
        space.subactionPath = hands_[hand];
        space.poseInActionSpace = kIdentityPose;
        DPL_XR(xrCreateActionSpace, session, &space, &aimSpaces_[hand]);
    }
    session_ = session;
    return {};
}

void Actions::detach() {
    for (XrSpace& space : aimSpaces_) {
        if (space) xrDestroySpace(space);
        space = XR_NULL_HANDLE;
    }
    session_ = XR_NULL_HANDLE;
}

Status Actions::sync(Calls& calls_, XrSpace world, XrTime time, Controllers& controllers) {
    if (!session_) return {};
    const XrActiveActionSet active{set_, XR_NULL_PATH};
    XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO};
    info.countActiveActionSets = 1;
    info.activeActionSets = &active;
    DPL_XR(xrSyncActions, session_, &info);
    for (int hand = 0; hand < 2; ++hand) {
        Controller& controller = controllers.hands[hand];
        XrActionStateBoolean select{XR_TYPE_ACTION_STATE_BOOLEAN};
        const XrActionStateGetInfo ofSelect = stateInfo(select_, hands_[hand]), ofTurn = stateInfo(turn_, hands_[hand]);
        DPL_XR(xrGetActionStateBoolean, session_, &ofSelect, &select);
        XrActionStateFloat turn{XR_TYPE_ACTION_STATE_FLOAT};
        DPL_XR(xrGetActionStateFloat, session_, &ofTurn, &turn);
        const bool held = select.isActive && select.currentState;
        controller.selected = held && !controller.select;
        controller.select = held;
        controller.turn = turn.isActive && std::isfinite(turn.currentState) ? std::clamp(turn.currentState, -1.0f, 1.0f) : 0;
        XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
        DPL_XR(xrLocateSpace, aimSpaces_[hand], world, time, &location);
        constexpr XrSpaceLocationFlags kNeeded = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
        controller.aim = location.pose;
        controller.tracked = (location.locationFlags & kNeeded) == kNeeded && makeValid(controller.aim);
    }
    return {};
}

}  // namespace dpl::xr
