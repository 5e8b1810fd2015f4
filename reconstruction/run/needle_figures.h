// SPDX-License-Identifier: Apache-2.0
// What stands out of an avatar's clothes, for the report: in the stress poses, and in moves that nobody filmed.
#pragma once

#include "reconstruction/judging/report/report.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Adds clothNeedles() of each garment to `data`: over the stress poses with keys "needles.GARMENT.…", and over each of moveClips() with
 *  keys "needles_walking.GARMENT.…" and so on, at most eight poses of a round before which the clothes remember another one. Only the
 *  stress poses have a bar, on the longest edge: weights are bounded there. Adds nothing without garments or on a rig without legs. The
 *  avatar must have passed the checks of its reader. */
void addNeedleFigures(const AvatarData& avatar, Jobs& jobs, ReportData& data);

}  // namespace dpl
