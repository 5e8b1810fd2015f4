// SPDX-License-Identifier: Apache-2.0
// From what training left behind to an avatar as its readers will see it.
#pragma once

#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/splat/co_optimise.h"

namespace dpl {

struct AssembledAvatar {
    AvatarData avatar;               // decoded: splats are bound to the vertices that a reader gets
    std::vector<TrainFrame> frames;  // training frames with their trained poses
};

/** The trained avatar, encoded and decoded once, splats re-based onto the decoded mesh, SH as a palette (write it with
 *  WriteOptions::shPalette). No evidence rows yet. */
Result<AssembledAvatar> assembleAvatar(const SubjectData& subject);

}  // namespace dpl
