// SPDX-License-Identifier: Apache-2.0
// An avatar of the procedural subject without a scan: splats painted on its true surface in the light of its pictures.
#pragma once

#include "reconstruction/subject/face/expression_nodes.h"
#include "reconstruction/subject/sample/subject.h"
#include "sdk/core/result.h"

namespace dpl {

/** The shapes of the subject's face: fields of the body before morphs, as its colours are, on the vertices of its body layer. */
std::vector<ExpressionShape> subjectFace(const Subject& subject);

/** About 180k splats in the order of files, small where prints and stripes end, and two clips at 30 Hz: "walk", one cycle of steps on the
 * spot, and "moves", the subject's motion in its scan (18.75 s). Colours are those of the standing pose; cloth follows the skinning alone.
 * 51 expressions (face_shapes.h). Same bytes for any thread count. About five seconds on two cores. */
AvatarData makeSampleAvatar(const Subject& subject, Jobs& jobs);

/** The avatar as the bytes of a .glb file. */
Result<std::vector<uint8_t>> makeSampleAvatarFile(const Subject& subject, Jobs& jobs);

/** Steps on the spot, one cycle of 1.1 s whose last key equals the first. On the built-in skeleton. */
ClipData walkOnTheSpot();

}  // namespace dpl
