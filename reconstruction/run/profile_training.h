// SPDX-License-Identifier: Apache-2.0
// Speed of training steps, on a scan or on the procedural subject (`doppel bench training`).
#pragma once

#include "reconstruction/run/reconstruct.h"
#include "reconstruction/training/trainer/profile_steps.h"

namespace dpl {

/** Measures steps of the training that reconstruct() would do. With a scan, runs the stages before the training unless they are up to date,
 *  and the output folder keeps them. Without one, trains on the procedural subject of options.seed in its true poses, in pictures of
 *  widthPx x heightPx; motion modes and the light of the scene are then left out. Errors as of reconstruct(). */
Result<ProfiledTraining> profileTraining(const ReconstructOptions& options, uint32_t widthPx, uint32_t heightPx, const ProfiledSteps& steps,
                                         Progress& progress);

}  // namespace dpl
