// SPDX-License-Identifier: Apache-2.0
// What a change of clothes does to the body below: skin that shows now and that no picture showed, and skin that is covered now
// (docs/reference/dress.md).
#pragma once

#include <span>

#include "reconstruction/output/dress/layer_part.h"
#include "reconstruction/output/dress/splat_fill.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct BodyChange {
    uint32_t filledTriangles = 0;   // without pictures: coloured from the skin around them
    uint32_t clearedTriangles = 0;  // deep below the new clothes
    Marks shown;                    // per triangle of all that is worn, in its order: shows from some side at rest
    bool noSkin = false;            // no splats of skin were there to take colours from; nothing was filled
};

/** Changes the body, worn.front(). Skin that shows now and lay below clothes takes splats in the colours of the skin around it. Skin that
 *  pictures saw stays, but beside the old clothes where it has taken their colour, and in the face everywhere. Skin deep below the new
 *  clothes loses its splats. Skin below `kept` stays as it is. What shows is found by drawing the mesh at rest from all sides. before: the
 * avatar in its old clothes. worn: body, kept layers, new layers; the first `kept` of them were worn before. The result does not depend on
 * the number of threads. */
BodyChange changeBody(const AvatarData& before, size_t kept, std::span<LayerPart> worn, Jobs& jobs);

}  // namespace dpl
