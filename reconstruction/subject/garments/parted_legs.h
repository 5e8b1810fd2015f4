// SPDX-License-Identifier: Apache-2.0
// Trousers or skirt: whether cloth that the hull joins between the legs is two tubes or one. Moving pictures tell, where the legs part.
#pragma once

#include <span>

#include "reconstruction/subject/garments/still_views.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** What the pictures show between the legs: pixels that cloth spans when it is one tube, and leaves free when it is two. */
struct BetweenLegs {
    size_t cloth = 0;  // pixels with the garment's label: a skirt
    size_t free = 0;   // pixels with skin or background: trousers

    bool parted() const;
};

/** A garment in both forms: rest positions with skin weights. */
struct LegForms {
    const MeshData& joined;            // one tube
    std::span<const uint8_t> between;  // of its triangles; 1: lies between the legs
    const MeshData& parted;            // two tubes
    uint8_t label = 0;                 // of the garment in the pictures
    uint8_t bare = 0;                  // of skin
};

/** Poses both forms as in each picture and counts the pixels in which `joined` shows a triangle between the legs, and `parted` shows
 *  nothing. Elsewhere the forms differ too, by their weights,
 *  but that tells nothing. In the picture the garment must be on both sides, in the same row: below a hem that swung up, a skirt shows the
 *  legs too. Pixels with another label than the garment's and `bare`, that of skin, count for neither. Views without labels are left out,
 *  and of more than 48 views an even share is used. */
BetweenLegs betweenLegs(const LegForms& garment, std::span<const JointData> joints, std::span<const GarmentView> moving, Jobs& jobs);

}  // namespace dpl
