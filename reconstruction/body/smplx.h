// SPDX-License-Identifier: Apache-2.0
// SMPL-X (and SMPL-H, SMPL) .npz to a BodyModel. The file is the user's own copy: its licence is theirs to hold, nothing of it ships here.
#pragma once

#include <filesystem>

#include "reconstruction/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

struct SmplxOptions {
    uint32_t shapeCount = 10;  // leading shape directions kept as morphs "shape00" ...
};

/** Reads v_template, shapedirs, J_regressor, weights, kintree_table and f. Joint names by the joint count (55 SMPL-X, 52 SMPL-H,
 *  24 SMPL), metres, +Y up, facing +Z, moved so that the feet stand at y = 0. Skin weights are cut to four. Pose correctives and
 *  expression directions are left out. Errors name the file and the array. */
Result<BodyModel> importSmplx(const std::filesystem::path& npz, const SmplxOptions& options = {});

}  // namespace dpl
