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

/** Poses both forms of a garment (rest positions with skin weights) as in each picture and counts the pixels in which `joined` shows a
 *  triangle that lies `between` the legs (a flag for each), and `parted` shows nothing. Elsewhere the forms differ too, by their weights,
 *  but that tells nothing. In the picture the garment must be on both sides, in the same row: below a hem that swung up, a skirt shows the
 *  legs too. Pixels with another label than the garment's and `bare`, that of skin, count for neither. Views without labels are left out,
 *  and of more than 48 views an even share is used. */
BetweenLegs betweenLegs(const MeshData& joined, std::span<const uint8_t> between, const MeshData& parted, uint8_t label, uint8_t bare,
                        std::span<const JointData> joints, std::span<const GarmentView> moving, Jobs& jobs);

}  // namespace dpl
