// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/expression_stream.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "sdk/core/edit_distance.h"

namespace dpl {
namespace {

constexpr size_t kLiveLinkCount = 61;  // ARKit's 52, then the angles

constexpr std::array<std::string_view, 10> kSilent{"_neutral",     "HeadYaw",     "HeadPitch",   "HeadRoll",      "LeftEyeYaw",
                                                   "LeftEyePitch", "LeftEyeRoll", "RightEyeYaw", "RightEyePitch", "RightEyeRoll"};

/** A share of one of ARKit's expressions in another stream's. */
struct Share {
    std::string_view of;    // the other stream's name
    std::string_view name;  // ARKit's; "Both": left and right
    float weight;
};
constexpr Share kShares[] = {
    {"happy", "mouthSmileBoth", 0.8f},
    {"happy", "cheekSquintBoth", 0.5f},
    {"happy", "eyeSquintBoth", 0.3f},
    {"angry", "browDownBoth", 1},
    {"angry", "mouthPressBoth", 0.5f},
    {"angry", "noseSneerBoth", 0.5f},
    {"sad", "browInnerUp", 0.8f},
    {"sad", "mouthFrownBoth", 0.8f},
    {"relaxed", "mouthSmileBoth", 0.3f},
    {"relaxed", "eyeBlinkBoth", 0.2f},
    {"surprised", "eyeWideBoth", 1},
    {"surprised", "browInnerUp", 0.8f},
    {"surprised", "browOuterUpBoth", 0.8f},
    {"surprised", "jawOpen", 0.4f},
    {"aa", "jawOpen", 0.7f},
    {"ih", "jawOpen", 0.25f},
    {"ih", "mouthStretchBoth", 0.4f},
    {"ou", "mouthPucker", 0.8f},
    {"ou", "jawOpen", 0.15f},
    {"ee", "mouthStretchBoth", 0.6f},
    {"ee", "mouthSmileBoth", 0.2f},
    {"ee", "jawOpen", 0.1f},
    {"oh", "mouthFunnel", 0.7f},
    {"oh", "jawOpen", 0.4f},
    {"blink", "eyeBlinkBoth", 1},
    {"blinkLeft", "eyeBlinkLeft", 1},
    {"blinkRight", "eyeBlinkRight", 1},
    {"lookUp", "eyeLookUpBoth", 1},
    {"lookDown", "eyeLookDownBoth", 1},
    {"lookLeft", "eyeLookOutLeft", 1},
    {"lookLeft", "eyeLookInRight", 1},
    {"lookRight", "eyeLookInLeft", 1},
    {"lookRight", "eyeLookOutRight", 1},
};

void add(std::string_view name, float weight, ExpressionWeights& weights) {
    if (const auto expression = expressionOf(name)) weights[*expression] += weight;
}

/** False: no such name. */
bool addNamed(std::string_view name, float weight, ExpressionWeights& weights) {
    if (expressionOf(name)) return add(name, weight, weights), true;
    if (name.ends_with("_L") || name.ends_with("_R")) {  // ARKit's raw values in Swift: "eyeBlink_L"
        const std::string full = std::string(name.substr(0, name.size() - 2)) + (name.back() == 'L' ? "Left" : "Right");
        return expressionOf(full) && (add(full, weight, weights), true);
    }
    bool known = name == "neutral" || std::find(kSilent.begin(), kSilent.end(), name) != kSilent.end();
    for (const Share& share : kShares) {
        if (share.of != name) continue;
        known = true;
        if (!share.name.ends_with("Both")) {
            add(share.name, share.weight * weight, weights);
            continue;
        }
        const std::string stem(share.name.substr(0, share.name.size() - 4));
        for (const char* side : {"Left", "Right"}) add(stem + side, share.weight * weight, weights);
    }
    return known;
}

float held(float weight) {
    return std::clamp(weight, 0.0f, 1.0f) + 0.0f;  // + 0.0f turns −0 into 0
}

}  // namespace

Result<ExpressionWeights> expressionFrom(std::span<const char* const> names, std::span<const float> weights) {
    if (names.empty() && weights.size() != kExpressionCount && weights.size() != kLiveLinkCount)
        return fail(Code::InvalidArgument, "{} weights without names; {} are ARKit's and {} Live Link's, others need their names",
                    weights.size(), kExpressionCount, kLiveLinkCount);
    ExpressionWeights out{};
    for (size_t i = 0; i < weights.size(); ++i) {
        if (names.empty() && i >= kExpressionCount) break;  // angles
        const char* name = names.empty() ? kExpressionNames[i] : names[i];
        if (name == nullptr) return fail(Code::InvalidArgument, "name {} of {} is NULL", i, weights.size());
        if (std::isnan(weights[i])) return fail(Code::InvalidArgument, "the weight of '{}' is not a number", name);
        if (!addNamed(name, held(weights[i]), out))
            return fail(Code::InvalidArgument, "there is no expression '{}'{}; names are those of ARKit, MediaPipe, Live Link or VRM", name,
                        didYouMean(name, {kExpressionNames.begin(), kExpressionNames.end()}));
    }
    for (float& weight : out) weight = held(weight);
    return out;
}

}  // namespace dpl
