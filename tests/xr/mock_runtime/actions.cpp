// SPDX-License-Identifier: Apache-2.0
// Actions: what the caller declares, and what the hands of the settings do. An action reads the inputs of the bindings that were suggested
// for the profile of the settings.
#include <algorithm>
#include <cmath>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr {
namespace {

constexpr const char* kHands[] = {"/user/hand/left", "/user/hand/right"};

XrResult checkName(const char* name, bool text, const std::string& what) {
    if (!text) return violated(XR_ERROR_NAME_INVALID, what + " has no name");
    for (const char* c = name; *c; ++c)
        if (!((*c >= 'a' && *c <= 'z') || (*c >= '0' && *c <= '9') || *c == '-' || *c == '_' || *c == '.'))
            return violated(XR_ERROR_PATH_FORMAT_INVALID, what + " has a name with other than small letters: " + name);
    return XR_SUCCESS;
}

struct Input {
    bool active = false;
    XrVector2f value{};
};

/** The strongest input that is bound to an action, on the hands that the subaction path allows. */
XrResult readInput(XrSession handle, const XrActionStateGetInfo* info, XrActionType type, Input& out) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_ACTION_STATE_GET_INFO, "getInfo"));
    const auto action = r.actions.find(info->action);
    if (action == r.actions.end()) return violated(XR_ERROR_HANDLE_INVALID, "the action is not alive");
    if (action->second.type != type) return violated(XR_ERROR_ACTION_TYPE_MISMATCH, action->second.name + " has another type");
    const Session& session = r.sessions.at(handle);
    if (std::find(session.attachedSets.begin(), session.attachedSets.end(), action->second.set) == session.attachedSets.end())
        return violated(XR_ERROR_ACTIONSET_NOT_ATTACHED, "the set of " + action->second.name + " is not attached");
    std::string only;
    if (info->subactionPath != XR_NULL_PATH) {
        DPL_MOCKXR_TRY(checkPath(info->subactionPath));
        const auto& allowed = action->second.subactions;
        if (std::find(allowed.begin(), allowed.end(), info->subactionPath) == allowed.end())
            return violated(XR_ERROR_PATH_UNSUPPORTED, action->second.name + " was made without that subaction path");
        only = r.instance->paths[info->subactionPath - 1];
    }
    if (!session.synced || session.told != XR_SESSION_STATE_FOCUSED) return XR_SUCCESS;
    const auto& bindings = r.instance->bindings[info->action];
    const auto bound = bindings.find(r.settings.interactionProfile);
    if (bound == bindings.end()) return XR_SUCCESS;
    for (const std::string& path : bound->second)
        for (int hand = 0; hand < 2; ++hand) {
            const std::string prefix = std::string(kHands[hand]) + "/";
            if (path.compare(0, prefix.size(), prefix) != 0 || (!only.empty() && only != kHands[hand])) continue;
            if (!r.settings.hands[hand].held) continue;
            out.active = true;
            const auto& inputs = r.settings.hands[hand].inputs;
            const auto input = inputs.find(path.substr(prefix.size()));
            if (input == inputs.end()) continue;
            if (std::hypot(input->second.x, input->second.y) > std::hypot(out.value.x, out.value.y)) out.value = input->second;
        }
    return XR_SUCCESS;
}

}  // namespace

namespace entry {

DPL_MOCKXR_ENTRY(xrCreateActionSet)(XrInstance, const XrActionSetCreateInfo* info, XrActionSet* set) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_ACTION_SET_CREATE_INFO, "createInfo"));
    DPL_MOCKXR_TRY(checkName(info->actionSetName, hasText(info->actionSetName), "the action set"));
    if (!hasText(info->localizedActionSetName)) return violated(XR_ERROR_LOCALIZED_NAME_INVALID, "the action set has no localized name");
    for (const auto& [handle, other] : r.actionSets)
        if (other.name == info->actionSetName) return violated(XR_ERROR_NAME_DUPLICATED, "two action sets are called " + other.name);
    *set = r.newHandle<XrActionSet>();
    r.actionSets[*set] = {info->actionSetName, false};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyActionSet)(XrActionSet set) {
    std::erase_if(runtime().actions, [&](const auto& action) { return action.second.set == set; });
    runtime().actionSets.erase(set);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreateAction)(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_ACTION_CREATE_INFO, "createInfo"));
    DPL_MOCKXR_TRY(checkName(info->actionName, hasText(info->actionName), "the action"));
    if (!hasText(info->localizedActionName)) return violated(XR_ERROR_LOCALIZED_NAME_INVALID, "the action has no localized name");
    if (r.actionSets.at(set).attached) return violated(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the action set is attached already");
    for (const auto& [handle, other] : r.actions)
        if (other.set == set && other.name == info->actionName)
            return violated(XR_ERROR_NAME_DUPLICATED, "two actions are called " + other.name);
    for (uint32_t i = 0; i < info->countSubactionPaths; ++i) {
        DPL_MOCKXR_TRY(checkPath(info->subactionPaths[i]));
        const std::string& path = r.instance->paths[info->subactionPaths[i] - 1];
        if (path != kHands[0] && path != kHands[1]) return violated(XR_ERROR_PATH_UNSUPPORTED, path + " is no subaction path");
    }
    *action = r.newHandle<XrAction>();
    r.actions[*action] = {
        set, info->actionName, info->actionType, {info->subactionPaths, info->subactionPaths + info->countSubactionPaths}};
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroyAction)(XrAction action) {
    runtime().actions.erase(action);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrSuggestInteractionProfileBindings)(XrInstance, const XrInteractionProfileSuggestedBinding* info) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, "suggestedBindings"));
    DPL_MOCKXR_TRY(checkPath(info->interactionProfile));
    const std::string profile = r.instance->paths[info->interactionProfile - 1];
    if (profile.compare(0, 22, "/interaction_profiles/") != 0)
        return violated(XR_ERROR_PATH_UNSUPPORTED, profile + " is no interaction profile");
    if (info->countSuggestedBindings == 0 || !info->suggestedBindings)
        return violated(XR_ERROR_VALIDATION_FAILURE, "no binding is suggested");
    for (auto& [action, bindings] : r.instance->bindings) bindings.erase(profile);
    for (uint32_t i = 0; i < info->countSuggestedBindings; ++i) {
        const XrActionSuggestedBinding& binding = info->suggestedBindings[i];
        const auto action = r.actions.find(binding.action);
        if (action == r.actions.end()) return violated(XR_ERROR_HANDLE_INVALID, "an action is not alive");
        if (r.actionSets.at(action->second.set).attached)
            return violated(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the action set is attached already");
        DPL_MOCKXR_TRY(checkPath(binding.binding));
        const std::string& path = r.instance->paths[binding.binding - 1];
        const size_t end = path.find('/', 11);
        if (path.compare(0, 11, "/user/hand/") != 0 || end == std::string::npos ||
            (path.compare(end, 7, "/input/") != 0 && path.compare(end, 8, "/output/") != 0))
            return violated(XR_ERROR_PATH_UNSUPPORTED, path + " is no path of a hand's input or output");
        r.instance->bindings[binding.action][profile].push_back(path);
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrAttachSessionActionSets)(XrSession handle, const XrSessionActionSetsAttachInfo* info) {
    Runtime& r = runtime();
    Session& session = r.sessions.at(handle);
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, "attachInfo"));
    if (session.attached) return violated(XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the session has action sets already");
    if (info->countActionSets == 0) return violated(XR_ERROR_VALIDATION_FAILURE, "no action set is attached");
    for (uint32_t i = 0; i < info->countActionSets; ++i)
        if (!r.actionSets.count(info->actionSets[i])) return violated(XR_ERROR_HANDLE_INVALID, "an action set is not alive");
    session.attachedSets.assign(info->actionSets, info->actionSets + info->countActionSets);
    for (const XrActionSet set : session.attachedSets) r.actionSets.at(set).attached = true;
    session.attached = true;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrSyncActions)(XrSession handle, const XrActionsSyncInfo* info) {
    Session& session = runtime().sessions.at(handle);
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_ACTIONS_SYNC_INFO, "syncInfo"));
    for (uint32_t i = 0; i < info->countActiveActionSets; ++i) {
        const auto& sets = session.attachedSets;
        if (std::find(sets.begin(), sets.end(), info->activeActionSets[i].actionSet) == sets.end())
            return violated(XR_ERROR_ACTIONSET_NOT_ATTACHED, "an action set is not attached");
    }
    session.synced = true;
    return session.told == XR_SESSION_STATE_FOCUSED ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

DPL_MOCKXR_ENTRY(xrGetActionStateBoolean)(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* state) {
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_ACTION_STATE_BOOLEAN, "state"));
    Input input;
    DPL_MOCKXR_TRY(readInput(session, info, XR_ACTION_TYPE_BOOLEAN_INPUT, input));
    state->isActive = input.active;
    state->currentState = input.value.x > 0.5f;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetActionStateFloat)(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state) {
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_ACTION_STATE_FLOAT, "state"));
    Input input;
    DPL_MOCKXR_TRY(readInput(session, info, XR_ACTION_TYPE_FLOAT_INPUT, input));
    state->isActive = input.active;
    state->currentState = input.value.x;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetActionStateVector2f)(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* state) {
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_ACTION_STATE_VECTOR2F, "state"));
    Input input;
    DPL_MOCKXR_TRY(readInput(session, info, XR_ACTION_TYPE_VECTOR2F_INPUT, input));
    state->isActive = input.active;
    state->currentState = input.value;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetActionStatePose)(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state) {
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_ACTION_STATE_POSE, "state"));
    Input input;
    DPL_MOCKXR_TRY(readInput(session, info, XR_ACTION_TYPE_POSE_INPUT, input));
    state->isActive = input.active;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetCurrentInteractionProfile)(XrSession, XrPath hand, XrInteractionProfileState* state) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkPath(hand));
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_INTERACTION_PROFILE_STATE, "interactionProfile"));
    const auto& paths = r.instance->paths;
    const auto found = std::find(paths.begin(), paths.end(), r.settings.interactionProfile);
    state->interactionProfile = found == paths.end() ? XR_NULL_PATH : XrPath(found - paths.begin()) + 1;
    return XR_SUCCESS;
}

}  // namespace entry
}  // namespace dpl::mockxr
