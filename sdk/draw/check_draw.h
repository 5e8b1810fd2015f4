// SPDX-License-Identifier: Apache-2.0
// What both renderers require of a draw. One check, so that a fault gives the same code and sentence on every renderer.
#pragma once

#include <optional>
#include <span>

#include "sdk/core/function_ref.h"
#include "sdk/draw/renderer.h"

namespace dpl {

/** One to kMaxViews cameras of the same size, whose sides are 1 to kMaxImageSidePx pixels. Focal lengths are above 0, the rotation is a
 * rotation, and all numbers are finite and in a range whose products stay finite. InvalidArgument names the view. */
Status checkViews(std::span<const Cameraf> views);

/** The joints of a loaded avatar, an empty span for general splats, nothing where the renderer has no such subject. */
using FindJoints = FunctionRef<std::optional<std::span<const JointData>>(RenderAvatarId)>;

/** Everything about a draw: views, scene depths, and 1 to kMaxDrawnTogether different loaded subjects, avatars with a pose that passes
 * checkPose. InvalidArgument. Allocates nothing unless it fails. */
Status checkDraw(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants, FindJoints findJoints);

}  // namespace dpl
