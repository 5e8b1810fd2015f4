// SPDX-License-Identifier: Apache-2.0
// The expressions of a body on an avatar that was made of it: by geometry alone, as its face was not filmed.
#pragma once

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** The body's shapes at the size of the avatar's head: offsets grow with the spread of the vertices that move. Their order is that of the
 *  body; vertices of other layers stay. The first layer of the mesh must hold the body's vertices in their order. */
std::vector<ExpressionShape> shapesAtSize(const BodyModel& body, const MeshData& mesh);

/** Gives the avatar the expressions of the body before any fit, and returns the row for
 * its evidence. An avatar whose first layer is not that body's, or that has expressions already, is refused (InvalidArgument). Without
 * expressions of the body it stays as it is, and the row says so. */
Result<EvidenceData> addBodyFace(AvatarData& avatar, const BodyModel& body);

}  // namespace dpl
