// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/face_gaze.h"

#include <algorithm>
#include <cmath>

#include "sdk/format/expression_names.h"
#include "sdk/motion/gaze.h"

namespace dpl {
namespace {

constexpr double kStillRad = 1e-4;  // of an eye that rounding alone has turned: its face keeps the bytes of one at rest
constexpr std::array<const char*, 2> kEyeBones = {"leftEye", "rightEye"};

/** The expressions that move an eye to the subject's left, right, up and down. */
struct EyeLooks {
    std::array<size_t, 4> of;
};

std::array<EyeLooks, 2> eyeLooks() {
    const auto all = [](const std::array<const char*, 4>& names) {
        EyeLooks looks{};
        std::transform(names.begin(), names.end(), looks.of.begin(), [](const char* name) { return *expressionOf(name); });
        return looks;
    };
    return {all({"eyeLookOutLeft", "eyeLookInLeft", "eyeLookUpLeft", "eyeLookDownLeft"}),
            all({"eyeLookInRight", "eyeLookOutRight", "eyeLookUpRight", "eyeLookDownRight"})};
}

}  // namespace

FaceEyes FaceEyes::of(const AvatarData& avatar) {
    FaceEyes eyes;
    for (size_t side = 0; side < 2; ++side)
        for (size_t j = 0; j < avatar.joints.size(); ++j)
            if (avatar.joints[j].humanoidBone == kEyeBones[side]) eyes.joints[side] = j;
    for (size_t v = 0; v < avatar.mesh.jointIndices.size() && !eyes.carrySkin; ++v)
        for (int k = 0; k < 4; ++k)
            if (avatar.mesh.jointWeights[v][k] > 0 &&
                (eyes.joints[0] == size_t(avatar.mesh.jointIndices[v][k]) || eyes.joints[1] == size_t(avatar.mesh.jointIndices[v][k])))
                eyes.carrySkin = true;
    return eyes;
}

ExpressionWeights withGaze(const ExpressionWeights& weights, const FaceEyes& eyes, std::span<const Quatf> localRotations) {
    static const std::array<EyeLooks, 2> kLooks = eyeLooks();
    ExpressionWeights shown = weights;
    for (size_t side = 0; side < 2; ++side) {
        if (!eyes.joints[side]) continue;
        const Vec2d turned = gazeTurn(localRotations[*eyes.joints[side]]);
        for (int axis = 0; axis < 2; ++axis) {
            if (std::abs(turned[axis]) < kStillRad) continue;
            const auto share = float(std::min(std::abs(turned[axis]) / double(kUsualEyeLimitRad[axis]), 1.0));
            float& weight = shown[kLooks[side].of[size_t(2 * axis + (turned[axis] < 0 ? 1 : 0))]];
            weight = eyes.carrySkin ? std::min(weight, 1 - share) : std::min(weight + share, 1.0f);
        }
    }
    return shown;
}

}  // namespace dpl
