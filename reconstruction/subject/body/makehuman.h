// SPDX-License-Identifier: Apache-2.0
// Imports MakeHuman / MPFB2 data (CC0) as a BodyModel.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/body/body_model.h"
#include "reconstruction/subject/body/makehuman_files.h"
#include "sdk/core/result.h"

namespace dpl {

struct MakeHumanOptions {
    std::string rig = "game_engine";  // rigs/standard/rig.NAME.json + weights.NAME.json
};

/** Where a vertex of an imported body is on the base mesh: mix(root, vertex, share) of places and of offsets. Skin, eyeballs, teeth and
 *  tongue are vertices of the base mesh. Lashes stand on the nearest skin with a quarter of their length, as MakeHuman's are cards for
 *  pictures with holes. */
struct MakeHumanVertex {
    uint32_t vertex = 0, root = 0;
    float share = 1;

    Vec3f of(std::span<const Vec3f> values) const { return glm::mix(values[root], values[vertex], share); }
};

/** The vertices of every body that importMakeHuman makes of this mesh: skin, then the parts of the face. */
std::vector<MakeHumanVertex> makeHumanVertices(const MakeHumanMesh& mesh);

/** The folder with `3dobjs/base.obj`: the given one, or `mpfb2` in it. NotFound. */
Result<std::filesystem::path> makeHumanRoot(const std::filesystem::path& folder);

/** Adds `factor` times a target, such as "head/head-trans-forward", to one offset per vertex of the base mesh, metres. */
Status addMakeHumanTarget(const std::filesystem::path& root, const std::string& name, float factor, std::vector<Vec3f>& offsetsM);

/** Reads the hm08 base mesh, targets, rig and weights. `folder` holds `3dobjs/base.obj`, or is the parent of that folder.
 *  The result is the neutral adult (half male, half female, equal thirds of the three shape families) in metres, +Y up, facing +Z, feet
 *  at y = 0. Eyeballs, teeth, tongue and lashes belong to the body layer. With `rig-makehuman` beside or in the folder there are joints
 *  leftEye, rightEye and jaw: the eyeballs follow the eyes, and lower teeth, tongue and skin of the jaw follow the jaw. Other helper
 *  geometry and joint cubes are dropped after the morphs' joint offsets are taken from the cubes. MakeHuman's macro targets are
 *  multilinear; each becomes one linear morph about the neutral body. NotFound and CorruptData name the file. Any thread. */
Result<BodyModel> importMakeHuman(const std::filesystem::path& folder, const MakeHumanOptions& options = {});

}  // namespace dpl
