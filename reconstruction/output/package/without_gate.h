// SPDX-License-Identifier: Apache-2.0
// What is left of splats in files that have no single-face gate.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Factors of the opacity, 0 to 1, one a splat, with which an avatar looks without its single-face gate as it does with it.
 *
 *  Other viewers draw both sides of every splat. Then the insides of an avatar show where its outside is thin: the far wall of the head
 *  between the hairs, an eye socket through the brow. In views from all around, near and far, g is what a splat adds to a picture behind
 * its gate, and u what it adds without one. The factor is that of the best fit, Σ u·g / Σ u², so what only shows from inside is left out,
 * and the outside, which is the same either way, stays. As splats go, others behind them begin to show, so it is fitted again.
 *
 *  poses: at least one; the factors are for all of them together. They must have passed checkPose. Takes 8 s of a core for a pose and
 *  50,000 splats; taskAt hears how far it is. Cancelled: that task was. */
Result<std::vector<float>> opacityWithoutGate(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs);

/** How far exports move single-face splats inwards. At the outline, the gate fades splats that are seen at a slant and hides those behind;
 *  without it both stick out, and viewers with a wider low-pass add to that (docs/notebook/2026-11-29-exported-splats.md). */
constexpr float kSunkM = 3e-4f;

/** The avatar with these opacities, without the splats that then never show. */
Result<AvatarData> withoutGate(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs);

}  // namespace dpl
