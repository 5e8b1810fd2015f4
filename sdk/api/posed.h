// SPDX-License-Identifier: Apache-2.0
// What the calls of doppel_posed.h keep of an avatar. context->mutex guards it.
#pragma once

#include <optional>
#include <vector>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/splat/posed_splats.h"
#include "sdk/visibility/detail.h"

namespace dpl::api {

struct PosedOutput {
    Jobs jobs{1};
    PosedMesh mesh;
    bool posed = false;  // `mesh` is of these:
    Pose pose;
    uint64_t hiddenLayers = 0;
    std::vector<Vec3f> normals;           // at rest; empty without light
    std::optional<DetailSubject> detail;  // made by the first budget
    PosedSplatWriter writer;
    std::optional<uint32_t> chosenFor;  // splatBudget of what the writer has chosen
    uint32_t chosen = 0;
    std::optional<RestNormals> restNormals;  // made by the first normals
    std::vector<Vec3f> meshNormals;
};

}  // namespace dpl::api
