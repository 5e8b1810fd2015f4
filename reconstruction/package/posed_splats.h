// SPDX-License-Identifier: Apache-2.0
// One posed frame of an avatar as general splats, for every other viewer.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr float kFlatThicknessM = 1e-4f;  // standard deviation across the surface of an exported flat splat

/** World-space splats of the avatar in `pose`: axes by the singular values of A, SH turned band by band with each triangle.
 *  Splats of degenerate triangles are left out. Single-face splats lose their gate: other viewers show them from both sides. */
Result<StaticSplatData> posedSplats(const AvatarData& avatar, const Pose& pose);

struct ExportOptions {
    std::filesystem::path avatar, out;  // kind by the extension of `out`: .ply or .glb
    std::string clip;                   // name of a clip in the avatar, or a BVH/glTF file; empty: rest pose
    double timeS = 0;
};

/** Reads, poses, writes; a file of general splats is read and written as it is. Returns a line for people. */
Result<std::string> exportPosedSplats(const ExportOptions& options);

}  // namespace dpl
