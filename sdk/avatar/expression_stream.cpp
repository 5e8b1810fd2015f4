// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/expression_stream.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>
#include <string_view>

#include "sdk/avatar/xr_expressions.h"
#include "sdk/core/edit_distance.h"
#include "sdk/format/vrm_expressions.h"

namespace dpl {
namespace {

constexpr size_t kLiveLinkCount = 61;  // ARKit's 52, then the angles

constexpr std::array<std::string_view, 10> kSilent{"_neutral",     "HeadYaw",     "HeadPitch",   "HeadRoll",      "LeftEyeYaw",
                                                   "LeftEyePitch", "LeftEyeRoll", "RightEyeYaw", "RightEyePitch", "RightEyeRoll"};

/** VRM's name of an expression: of version 1 as it is, of version 0 in the words of version 1. Version 0 writes them small in files and
 * with capitals in programs ("blink_l", "Blink_L"). */
std::string_view vrmName(std::string_view name) {
    std::string small(name);
    std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    const auto old = std::find_if(std::begin(kVrm0Names), std::end(kVrm0Names), [&](const auto& pair) { return pair.first == small; });
    return old == std::end(kVrm0Names) ? name : old->second;
}

/** False: no such name. */
bool addNamed(std::string_view name, float weight, ExpressionWeights& weights) {
    std::string full(name);
    if (name.ends_with("_L") || name.ends_with("_R"))  // ARKit's raw values in Swift: "eyeBlink_L"
        full = full.substr(0, full.size() - 2) + (name.back() == 'L' ? "Left" : "Right");
    if (const auto expression = expressionOf(full)) {
        weights[*expression] += weight;
        return true;
    }
    if (const XrShare* share = xrShareOf(name)) {
        if (share->name != nullptr) weights[*expressionOf(share->name)] += share->weight * weight;
        return true;
    }
    const std::string_view vrm = vrmName(name);
    return vrm == "neutral" || std::find(kSilent.begin(), kSilent.end(), name) != kSilent.end() ||
           eachVrmShare(vrm, [&](size_t expression, float share) { weights[expression] += share * weight; });
}

/** A stream of so many weights needs no names, as it has one order. */
bool isKnownCount(size_t count) {
    return count == kExpressionCount || count == kLiveLinkCount || count == kXrShares.size() || count == kXrFirstShares;
}

float held(float weight) {
    return std::clamp(weight, 0.0f, 1.0f) + 0.0f;  // + 0.0f turns −0 into 0
}

}  // namespace

Result<ExpressionWeights> expressionFrom(std::span<const char* const> names, std::span<const float> weights) {
    if (names.empty() && !isKnownCount(weights.size()))
        return fail(Code::InvalidArgument,
                    "{} weights without names; {} are ARKit's, {} Live Link's, {} and {} OpenXR's, others need their names", weights.size(),
                    kExpressionCount, kLiveLinkCount, kXrFirstShares, kXrShares.size());
    const bool isXr = names.empty() && weights.size() > kLiveLinkCount;
    ExpressionWeights out{};
    for (size_t i = 0; i < weights.size(); ++i) {
        if (names.empty() && !isXr && i >= kExpressionCount) break;  // angles
        const char* name = !names.empty() ? names[i] : isXr ? kXrShares[i].xr : kExpressionNames[i];
        if (name == nullptr) return fail(Code::InvalidArgument, "name {} of {} is NULL", i, weights.size());
        if (std::isnan(weights[i])) return fail(Code::InvalidArgument, "the weight of '{}' is not a number", name);
        if (!addNamed(name, held(weights[i]), out))
            return fail(Code::InvalidArgument,
                        "there is no expression '{}'{}; names are those of ARKit, MediaPipe, Live Link, VRM or OpenXR", name,
                        didYouMean(name, {kExpressionNames.begin(), kExpressionNames.end()}));
    }
    for (float& weight : out) weight = held(weight);
    return out;
}

}  // namespace dpl
