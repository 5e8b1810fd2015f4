// SPDX-License-Identifier: Apache-2.0
// Imports MakeHuman / MPFB2 data (CC0) as a BodyModel.
#pragma once

#include <filesystem>
#include <string>

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

struct MakeHumanOptions {
    std::string rig = "game_engine";  // rigs/standard/rig.NAME.json + weights.NAME.json
};

/** Reads the hm08 base mesh, targets, rig and weights. `folder` holds `3dobjs/base.obj`, or is the parent of that folder.
 *  The result is the neutral adult (half male, half female, equal thirds of the three shape families) in metres, +Y up, facing +Z, feet
 *  at y = 0. Helper geometry and joint cubes are dropped after the morphs' joint offsets are taken from the cubes. MakeHuman's macro
 *  targets are multilinear; each becomes one linear morph about the neutral body. NotFound and CorruptData name the file. Any thread. */
Result<BodyModel> importMakeHuman(const std::filesystem::path& folder, const MakeHumanOptions& options = {});

}  // namespace dpl
