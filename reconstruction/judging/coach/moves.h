// SPDX-License-Identifier: Apache-2.0
// Moves that the moving frames of a scan lack, in words that a person can follow (docs/reference/body-map.md, "Moves").
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "reconstruction/judging/coach/shots.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** The moves of the guide to filming that no pose shows, as parts of a sentence ("lift one knee and then the other"), in its order. Moves
 * of bones that the rig does not name are left out. The poses must have passed checkPose. */
std::vector<std::string_view> missingMoves(std::span<const JointData> joints, std::span<const Pose> moving);

/** Advice to film the missing moves; none where none is missing. */
std::optional<Shot> movesToFilm(std::span<const JointData> joints, std::span<const Pose> moving);

}  // namespace dpl
