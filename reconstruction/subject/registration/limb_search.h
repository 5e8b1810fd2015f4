// SPDX-License-Identifier: Apache-2.0
// Least squares cannot take a limb from one depth to another. Where the keypoints of a limb fit badly over a run of frames, this tries the
// other depths that they allow. Private to reconstruction/subject/registration.
#pragma once

#include "reconstruction/subject/registration/picture_rounds.h"

namespace dpl {

/** Tries the moving frames of a split. A trial sets a limb over a run of frames, solves these and their neighbours by all terms, and stays
 *  when the cost of keypoints, priors, motion and pictures together is lower. `pictures` must have started a round, unless no frame has a
 *  picture. Returns the solves of the trials that stay. Errors: Cancelled. */
Result<std::vector<SolveEnd>> searchLimbs(FramePoses& poses, Split split, PictureRounds& pictures);

}  // namespace dpl
