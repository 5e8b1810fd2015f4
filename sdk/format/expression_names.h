// SPDX-License-Identifier: Apache-2.0
// The 52 expressions: names, order and meaning of ARKit's blend shapes. Left and right are the subject's own.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace dpl {

constexpr size_t kExpressionCount = 52;

constexpr std::array<const char*, kExpressionCount> kExpressionNames{
    "eyeBlinkLeft",      "eyeLookDownLeft",    "eyeLookInLeft",       "eyeLookOutLeft",   "eyeLookUpLeft",     "eyeSquintLeft",
    "eyeWideLeft",       "eyeBlinkRight",      "eyeLookDownRight",    "eyeLookInRight",   "eyeLookOutRight",   "eyeLookUpRight",
    "eyeSquintRight",    "eyeWideRight",       "jawForward",          "jawLeft",          "jawRight",          "jawOpen",
    "mouthClose",        "mouthFunnel",        "mouthPucker",         "mouthLeft",        "mouthRight",        "mouthSmileLeft",
    "mouthSmileRight",   "mouthFrownLeft",     "mouthFrownRight",     "mouthDimpleLeft",  "mouthDimpleRight",  "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower",     "mouthRollUpper",      "mouthShrugLower",  "mouthShrugUpper",   "mouthPressLeft",
    "mouthPressRight",   "mouthLowerDownLeft", "mouthLowerDownRight", "mouthUpperUpLeft", "mouthUpperUpRight", "browDownLeft",
    "browDownRight",     "browInnerUp",        "browOuterUpLeft",     "browOuterUpRight", "cheekPuff",         "cheekSquintLeft",
    "cheekSquintRight",  "noseSneerLeft",      "noseSneerRight",      "tongueOut"};

/** Index of a name; the first letter may be a capital one, as in Live Link. */
std::optional<size_t> expressionOf(std::string_view name);

}  // namespace dpl
