// SPDX-License-Identifier: Apache-2.0
// What goes wrong with an avatar's clothes in motion: garments inside the body, torn cloth, skin that shows through.
//
// The body is the layer with the role "body", garments those with the role "garment". docs/reference/metrics.md
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Share of garment vertices that lie inside the body, mean over the poses. Points deeper than 10 cm do not count: at such a depth the
 *  nearest part of the body is another one. 0 when the avatar has no body layer or no garment, or without poses. The avatar and the poses
 *  must have passed the checks of their readers. */
double garmentPenetration(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs);

/** Pixels that are wrong, seen from four sides. */
struct PixelFault {
    size_t mostPx = 0;     // in the worst pose
    size_t worstPose = 0;  // the first of them
    double share = 0;      // of all pixels that could be wrong, over all poses
};

/** Needles of one garment: what stands out of it where it stretches. */
struct GarmentNeedles {
    std::string name;
    double longestStretch = 1;  // largest ratio of an edge's length to its rest length
    double longestSplatM = 0;   // length from end to end of the longest splat as it is drawn; it ends where its opacity is 1/255
    PixelFault outside;         // of the pixels that the garment alone draws, those more than 2 cm outside the grown tubes (grown_tubes.h)
    PixelFault uncovered;       // of the pixels that see its posed mesh, those that the whole avatar leaves uncovered: alpha < 128
};

/** One entry a garment, over all poses. Empty without garments or poses. The avatar and the poses must have passed the checks of their
 *  readers. */
std::vector<GarmentNeedles> clothNeedles(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs);

struct ClothFaults {
    double penetration = 0;         // garmentPenetration()
    size_t worstPose = 0;           // the pose with the most penetration
    double stretchedEdges = 0;      // share of the garments' edges that are longer than twice their rest length, mean over the poses
    double longestStretch = 1;      // of all garments
    double longestSplatM = 0;       // of all garments
    PixelFault outside, uncovered;  // of all garments
    double skinPixels = 0;          // of the garments' pixels seen from four sides, the share in which the covered body comes through
    double offsetsAtWork = 1;       // length of the garments' learned offsets as drawn, over that without reaches; 1 without any
    std::vector<GarmentNeedles> garments;
};

/** Measures every pose. A pixel shows the body through a garment when its nearest surface is a body triangle that the garment covers at
 *  rest, and the outer side of a garment lies less than 10 cm behind. Without a body layer, a garment or poses nothing is measured and the
 *  figures stay as they are above. The avatar and the poses must have passed
 *  the checks of their readers. Errors: Cancelled. */
Result<ClothFaults> clothFaults(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs);

}  // namespace dpl
