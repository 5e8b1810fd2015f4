// SPDX-License-Identifier: Apache-2.0
// Level of detail in double precision, from docs/reference/level-of-detail.md: which splats are drawn, how opaque and how large.
#pragma once

#include "apps/reference/reference_renderer.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** Size of a pixel, metres, at the nearest point that the posed avatar may reach, in the camera that sees it finest. Every vertex lies in
 * the hull of one ball around each joint. */
double referenceFinestPixelM(const AvatarData& avatar, const Pose& pose, const std::vector<ReferenceCamera>& cameras);

/** Reduces the scene to perM2 splats a square metre of the rest surface. avatar.splats: the decoded numbers of `coded`; only the chunks of
 *  `coded` are read. */
void reduceReference(ReferenceScene& scene, const AvatarData& avatar, const CodedSplats& coded, double perM2);

/** General splats in the order of renderers (order[new] = old), reduced to perPixel splats a pixel. Each group is measured at the point
 *  where it comes nearest to the camera that sees it finest. */
std::vector<ReferenceGaussian> reducedReference(const StaticSplatData& splats, const std::vector<uint32_t>& order,
                                                const std::vector<ReferenceCamera>& cameras, double perPixel);

}  // namespace dpl
