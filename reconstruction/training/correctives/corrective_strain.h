// SPDX-License-Identifier: Apache-2.0
// Measures learned pose correctives in random poses far from the training poses, which the held-out frames of a scan do not contain.
#pragma once

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** 99th percentiles over 64 seeded random poses. */
struct CorrectiveStrain {
    double offsetMm = 0;       // length of a vertex's corrective offset
    double strainPercent = 0;  // offset difference between an edge's ends, relative to its length: high when cloth tears or crumples
    double lightPercent = 0;   // change of brightness
};

/** Rotates every joint that the correctives depend on by up to 60 degrees about a random axis; other joints stay at rest. All zero when the
 *  avatar has no correctives. The avatar must have passed the checks of the avatar reader. */
CorrectiveStrain correctiveStrain(const AvatarData& avatar, Jobs& jobs);

}  // namespace dpl
