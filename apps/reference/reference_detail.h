// SPDX-License-Identifier: Apache-2.0
// Level of detail in double precision, from docs/reference/level-of-detail.md: which splats are drawn, and their opacity and size.
#pragma once

#include "apps/reference/reference_renderer.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** Size of a pixel in metres at the point of the posed avatar nearest to the camera, for the camera with the finest pixels. The avatar is
 *  bounded by the convex hull of one ball around each joint, which holds every vertex. */
double referenceFinestPixelM(const AvatarData& avatar, const Pose& pose, const std::vector<ReferenceCamera>& cameras);

/** Reduces the scene to perM2 splats per square metre of the rest surface. avatar.splats must hold the decoded splats of `coded`; of
 * `coded` itself only the chunks are read. */
void reduceReference(ReferenceScene& scene, const AvatarData& avatar, const CodedSplats& coded, double perM2);

/** General splats in the renderers' order (order[new] = old), reduced to perPixel splats per pixel. The pixel size of a group is taken at
 * its point nearest to the camera that sees it finest. */
std::vector<ReferenceGaussian> reducedReference(const StaticSplatData& splats, const std::vector<uint32_t>& order,
                                                const std::vector<ReferenceCamera>& cameras, double perPixel);

}  // namespace dpl
