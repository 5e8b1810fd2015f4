// SPDX-License-Identifier: Apache-2.0
// Imports SMPL-X, SMPL-H and SMPL .npz files as a BodyModel. Users bring their own licensed file; Doppel ships no part of one.
#pragma once

#include <filesystem>

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

struct SmplxOptions {
    uint32_t shapeCount = 10;  // the first shape directions, kept as morphs "shape00" ...
};

/** Reads v_template, shapedirs, J_regressor, weights, kintree_table and f. The joint count (55 SMPL-X, 52 SMPL-H, 24 SMPL) selects the
 *  joint names. The body is in metres, +Y up, facing +Z, moved so that the feet stand at y = 0. Each vertex keeps its four largest skin
 *  weights. Pose correctives and expression directions are not read. Errors name the file and the array. */
Result<BodyModel> importSmplx(const std::filesystem::path& npz, const SmplxOptions& options = {});

}  // namespace dpl
