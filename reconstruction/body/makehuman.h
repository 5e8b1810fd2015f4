// SPDX-License-Identifier: Apache-2.0
// MakeHuman / MPFB2 data (CC0) to a BodyModel.
#pragma once

#include <filesystem>
#include <string>

#include "reconstruction/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

struct MakeHumanOptions {
    std::string rig = "game_engine";  // rigs/standard/rig.NAME.json + weights.NAME.json
};

/** Reads the folder that holds `3dobjs/base.obj` (or its parent): hm08 base mesh, targets, rig and weights. The result is the neutral
 *  adult (half male, half female, equal thirds of the three shape families), metres, +Y up, facing +Z, feet at y = 0, with helper
 *  geometry and joint cubes dropped; joints follow the morphs through their cubes. MakeHuman's macro targets are multilinear; here
 *  each is one linear morph about the neutral body. NotFound / CorruptData name the file. Any thread. */
Result<BodyModel> importMakeHuman(const std::filesystem::path& folder, const MakeHumanOptions& options = {});

}  // namespace dpl
