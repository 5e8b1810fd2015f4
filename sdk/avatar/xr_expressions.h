// SPDX-License-Identifier: Apache-2.0
// The expressions of OpenXR's XR_FB_face_tracking2 as shares of ARKit's. Those of XR_FB_face_tracking are the first 63, in the same order.
#pragma once

#include <array>
#include <string_view>

namespace dpl {

/** What one of OpenXR's expressions moves. Where OpenXR tells halves and quarters of what ARKit has as one, shares add up to 1. */
struct XrShare {
    const char* xr;    // of XrFaceExpression2FB, without "XR_FACE_EXPRESSION2_" and "_FB"
    const char* name;  // ARKit's; nullptr: ARKit has nothing of the kind
    float weight;
};

constexpr size_t kXrFirstShares = 63;  // of XR_FB_face_tracking
// In the order of the enumeration. "Left" is the subject's left in both lists.
constexpr std::array<XrShare, 70> kXrShares{{
    {"BROW_LOWERER_L", "browDownLeft", 1},
    {"BROW_LOWERER_R", "browDownRight", 1},
    {"CHEEK_PUFF_L", "cheekPuff", 0.5f},
    {"CHEEK_PUFF_R", "cheekPuff", 0.5f},
    {"CHEEK_RAISER_L", "cheekSquintLeft", 1},
    {"CHEEK_RAISER_R", "cheekSquintRight", 1},
    {"CHEEK_SUCK_L", nullptr, 0},
    {"CHEEK_SUCK_R", nullptr, 0},
    {"CHIN_RAISER_B", "mouthShrugLower", 1},
    {"CHIN_RAISER_T", "mouthShrugUpper", 1},
    {"DIMPLER_L", "mouthDimpleLeft", 1},
    {"DIMPLER_R", "mouthDimpleRight", 1},
    {"EYES_CLOSED_L", "eyeBlinkLeft", 1},
    {"EYES_CLOSED_R", "eyeBlinkRight", 1},
    {"EYES_LOOK_DOWN_L", "eyeLookDownLeft", 1},
    {"EYES_LOOK_DOWN_R", "eyeLookDownRight", 1},
    {"EYES_LOOK_LEFT_L", "eyeLookOutLeft", 1},
    {"EYES_LOOK_LEFT_R", "eyeLookInRight", 1},
    {"EYES_LOOK_RIGHT_L", "eyeLookInLeft", 1},
    {"EYES_LOOK_RIGHT_R", "eyeLookOutRight", 1},
    {"EYES_LOOK_UP_L", "eyeLookUpLeft", 1},
    {"EYES_LOOK_UP_R", "eyeLookUpRight", 1},
    {"INNER_BROW_RAISER_L", "browInnerUp", 0.5f},
    {"INNER_BROW_RAISER_R", "browInnerUp", 0.5f},
    {"JAW_DROP", "jawOpen", 1},
    {"JAW_SIDEWAYS_LEFT", "jawLeft", 1},
    {"JAW_SIDEWAYS_RIGHT", "jawRight", 1},
    {"JAW_THRUST", "jawForward", 1},
    {"LID_TIGHTENER_L", "eyeSquintLeft", 1},
    {"LID_TIGHTENER_R", "eyeSquintRight", 1},
    {"LIP_CORNER_DEPRESSOR_L", "mouthFrownLeft", 1},
    {"LIP_CORNER_DEPRESSOR_R", "mouthFrownRight", 1},
    {"LIP_CORNER_PULLER_L", "mouthSmileLeft", 1},
    {"LIP_CORNER_PULLER_R", "mouthSmileRight", 1},
    {"LIP_FUNNELER_LB", "mouthFunnel", 0.25f},
    {"LIP_FUNNELER_LT", "mouthFunnel", 0.25f},
    {"LIP_FUNNELER_RB", "mouthFunnel", 0.25f},
    {"LIP_FUNNELER_RT", "mouthFunnel", 0.25f},
    {"LIP_PRESSOR_L", "mouthPressLeft", 1},
    {"LIP_PRESSOR_R", "mouthPressRight", 1},
    {"LIP_PUCKER_L", "mouthPucker", 0.5f},
    {"LIP_PUCKER_R", "mouthPucker", 0.5f},
    {"LIP_STRETCHER_L", "mouthStretchLeft", 1},
    {"LIP_STRETCHER_R", "mouthStretchRight", 1},
    {"LIP_SUCK_LB", "mouthRollLower", 0.5f},
    {"LIP_SUCK_LT", "mouthRollUpper", 0.5f},
    {"LIP_SUCK_RB", "mouthRollLower", 0.5f},
    {"LIP_SUCK_RT", "mouthRollUpper", 0.5f},
    {"LIP_TIGHTENER_L", nullptr, 0},
    {"LIP_TIGHTENER_R", nullptr, 0},
    {"LIPS_TOWARD", "mouthClose", 1},
    {"LOWER_LIP_DEPRESSOR_L", "mouthLowerDownLeft", 1},
    {"LOWER_LIP_DEPRESSOR_R", "mouthLowerDownRight", 1},
    {"MOUTH_LEFT", "mouthLeft", 1},
    {"MOUTH_RIGHT", "mouthRight", 1},
    {"NOSE_WRINKLER_L", "noseSneerLeft", 1},
    {"NOSE_WRINKLER_R", "noseSneerRight", 1},
    {"OUTER_BROW_RAISER_L", "browOuterUpLeft", 1},
    {"OUTER_BROW_RAISER_R", "browOuterUpRight", 1},
    {"UPPER_LID_RAISER_L", "eyeWideLeft", 1},
    {"UPPER_LID_RAISER_R", "eyeWideRight", 1},
    {"UPPER_LIP_RAISER_L", "mouthUpperUpLeft", 1},
    {"UPPER_LIP_RAISER_R", "mouthUpperUpRight", 1},
    {"TONGUE_TIP_INTERDENTAL", nullptr, 0},
    {"TONGUE_TIP_ALVEOLAR", nullptr, 0},
    {"TONGUE_FRONT_DORSAL_PALATE", nullptr, 0},
    {"TONGUE_MID_DORSAL_PALATE", nullptr, 0},
    {"TONGUE_BACK_DORSAL_VELAR", nullptr, 0},
    {"TONGUE_OUT", "tongueOut", 1},
    {"TONGUE_RETREAT", nullptr, 0},
}};

/** By a name of either extension, with or without its prefix and suffix; nullptr: it is none of them. */
constexpr const XrShare* xrShareOf(std::string_view name) {
    for (const std::string_view prefix : {"XR_FACE_EXPRESSION2_", "XR_FACE_EXPRESSION_"})
        if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
    if (name.ends_with("_FB")) name.remove_suffix(3);
    for (const XrShare& share : kXrShares)
        if (name == share.xr) return &share;
    return nullptr;
}

}  // namespace dpl
