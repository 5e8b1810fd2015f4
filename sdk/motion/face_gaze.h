// SPDX-License-Identifier: Apache-2.0
// Eyes that the pose turns and eyes that expressions move, as one gaze. Formulas: docs/reference/expressions.md, "Eyes".
#pragma once

#include <array>
#include <optional>
#include <span>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** How an avatar's eyes move. */
struct FaceEyes {
    std::array<std::optional<size_t>, 2> joints;  // left, right; nothing: the pose does not turn that eye
    bool carrySkin = false;                       // the joints move eyeballs; else eyes are painted, and eyeLook* moves them alone

    static FaceEyes of(const AvatarData& avatar);
};

/** Weights of the face in a pose. The turn of an eye's joint comes first. Where it moves an eyeball, a weight of eyeLook* that goes the
 * same way keeps what is left of the limit, kUsualEyeLimitRad. Where it moves nothing, the turn itself is shown by eyeLook*, and what was
 * set comes on top. Joints at rest: the weights as they are. They are held in 0 to 1. */
ExpressionWeights withGaze(const ExpressionWeights& weights, const FaceEyes& eyes, std::span<const Quatf> localRotations);

}  // namespace dpl
