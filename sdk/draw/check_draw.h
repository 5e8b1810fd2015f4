// SPDX-License-Identifier: Apache-2.0
// Checks the arguments of a draw for every renderer, so that a fault gives the same code and sentence on all of them.
#pragma once

#include <optional>
#include <span>

#include "sdk/core/function_ref.h"
#include "sdk/draw/renderer.h"

namespace dpl {

constexpr float kMaxIntrinsicPx = 1e7f;  // of focal lengths and principal point: beyond any lens; keeps products finite
constexpr float kMaxDistanceM = 1e5f;    // of each coordinate of a view's translation; checkPose has the same limit for the root

/** Requires 1 to kMaxViews cameras of the same size, with sides of 1 to kMaxImageSidePx pixels, focal lengths above 0, rotations without
 * mirroring, and finite numbers small enough that products of them stay finite. InvalidArgument names the view. */
Status checkViews(std::span<const Cameraf> views);

/** Returns the joints of a loaded avatar, an empty span for general splats, and nullopt for an id that the renderer does not have. */
using FindJoints = FunctionRef<std::optional<std::span<const JointData>>(RenderAvatarId)>;

/** Requires views that pass checkViews, scene depths of their size, and 1 to kMaxDrawnTogether different loaded subjects; avatars need a
 * pose that passes checkPose. InvalidArgument otherwise. Allocates nothing unless it fails. */
Status checkDraw(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants, FindJoints findJoints);

}  // namespace dpl
