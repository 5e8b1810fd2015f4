// SPDX-License-Identifier: Apache-2.0
// What a closed mouth hides: teeth, tongue and the skin behind the lips. No picture shows it, so the body says what it looks like.
#pragma once

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** Gives triangles of the avatar's first layer splats of the body's own colours where no camera around the face sees them at rest, in place
 *  of those that they have. Only triangles within the box of what its expressions move count whose colours differ from the body's skin, so
 * a body of one colour leaves the avatar as it is. The first layer must hold the body's vertices and triangles. Returns how many triangles
 * were painted. Deterministic. */
Result<size_t> paintHiddenParts(AvatarData& avatar, const BodyModel& body);

}  // namespace dpl
