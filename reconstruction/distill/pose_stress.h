// SPDX-License-Identifier: Apache-2.0
// What learned pose correctives do in poses that nobody trained: held-out frames of one scan cannot show it, walks and dances do.
#pragma once

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** 99th percentiles over 64 seeded random poses. */
struct PoseStress {
    double offsetMm = 0;       // length of a vertex's pose-dependent offset
    double strainPercent = 0;  // difference of the offsets of an edge's ends over the edge's length: torn or crumpled cloth
    double lightPercent = 0;   // change of brightness
};

/** Every joint that the correctives hear is turned by up to 60 degrees about a random axis, the rest stays at rest. All zero without
 *  correctives. The avatar must have passed the reader's checks. */
PoseStress poseStress(const AvatarData& avatar, Jobs& jobs);

}  // namespace dpl
