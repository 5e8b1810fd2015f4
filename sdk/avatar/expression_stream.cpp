// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/expression_stream.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "sdk/core/edit_distance.h"
#include "sdk/format/vrm_expressions.h"

namespace dpl {
namespace {

constexpr size_t kLiveLinkCount = 61;  // ARKit's 52, then the angles

constexpr std::array<std::string_view, 10> kSilent{"_neutral",     "HeadYaw",     "HeadPitch",   "HeadRoll",      "LeftEyeYaw",
                                                   "LeftEyePitch", "LeftEyeRoll", "RightEyeYaw", "RightEyePitch", "RightEyeRoll"};

/** False: no such name. */
bool addNamed(std::string_view name, float weight, ExpressionWeights& weights) {
    std::string full(name);
    if (name.ends_with("_L") || name.ends_with("_R"))  // ARKit's raw values in Swift: "eyeBlink_L"
        full = full.substr(0, full.size() - 2) + (name.back() == 'L' ? "Left" : "Right");
    if (const auto expression = expressionOf(full)) {
        weights[*expression] += weight;
        return true;
    }
    return name == "neutral" || std::find(kSilent.begin(), kSilent.end(), name) != kSilent.end() ||
           eachVrmShare(name, [&](size_t expression, float share) { weights[expression] += share * weight; });
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
