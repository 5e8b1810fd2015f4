// SPDX-License-Identifier: Apache-2.0
// Level of detail in double precision, from the maths of docs/adr/0010: which splats of a posed avatar are drawn, how opaque and how large.
#pragma once

#include "sdk/format/coded_splats.h"
#include "tests/reference/reference_renderer.h"

namespace dpl {

/** Size of a pixel, metres, where the posed avatar may come nearest to the camera that sees it finest: every vertex lies in the hull of one
 * ball a joint. */
double referenceFinestPixelM(const AvatarData& avatar, const Pose& pose, const std::vector<ReferenceCamera>& cameras);

/** Takes from the scene what perM2 splats a square metre at rest leave out. avatar.splats: the numbers behind `coded`, of which only the
 * chunks are used. */
void reduceReference(ReferenceScene& scene, const AvatarData& avatar, const CodedSplats& coded, double perM2);

/** General splats in the order of renderers (order[new] = old), less what perPixel splats a pixel leave out where each half-chunk comes
 * nearest to the camera that sees it finest. */
std::vector<ReferenceGaussian> reducedReference(const StaticSplatData& splats, const std::vector<uint32_t>& order,
                                                const std::vector<ReferenceCamera>& cameras, double perPixel);

}  // namespace dpl
