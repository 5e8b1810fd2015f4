// SPDX-License-Identifier: Apache-2.0
// Converts one posed frame of an avatar to general splats, for other viewers.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/sh_rotation.h"

namespace dpl {

/** World-space splats of the avatar in `pose`, by sdk/splat/posed_splats.h. Axes are the principal axes of each posed splat; SH are rotated
 * with its triangle. Splats of degenerate triangles are left out. Single-face splats lose their gate: other viewers show them from both
 * sides. InvalidArgument: a pose that does not fit the rig or is not finite. */
Result<StaticSplatData> posedSplats(const AvatarData& avatar, const Pose& pose);

/** The same for many poses of one avatar, which must outlive it. One thread at a time. */
class SplatPoser {
public:
    /** sunkM: single-face splats are moved inwards by so much. */
    explicit SplatPoser(const AvatarData& avatar, float sunkM = 0);
    /** all: splats of degenerate triangles stay, with opacity 0, so that count and order are those of the avatar in every pose. */
    Result<StaticSplatData> in(const Pose& pose, bool all);

private:
    const AvatarData& avatar_;
    float sunkM_;
    Jobs jobs_{1};
    std::vector<RestTriangle<float>> rest_;
    std::vector<Vec3f> normals_;
    ClothLimits cloth_;
    PosedMesh posed_;
    ShRotator rotator_;
};

struct ExportOptions {
    std::filesystem::path avatar, out;  // the extension of `out` selects the format: .glb, .spz or .ply
    std::string clip;                   // name of a clip of the avatar, or path of a BVH or glTF file; empty: rest pose
    std::string animation;              // name or number of an animation in a glTF file; empty: the first
    double timeS = 0;
    std::string inputAxes;     // of general splats, instead of what they state: "y-up", "y-down", "z-up" or "z-down"; empty: as stated
    std::string axes;          // of a .ply: "y-down" (half a turn about z from ours) or "y-up"; empty: y-down, for other formats y-up
    uint32_t spzVersion = 4;   // 3 for older readers
    double fps = 0;            // frames a second of a whole clip, as files in the folder `out` (export_clip.h); 0: one frame
    std::string format;        // of these files: "spz", "ply" or "glb"
    uint32_t threadCount = 0;  // 0: one thread a core; files do not depend on it
};

/** Why a file of this name and these options cannot be written; empty if it can. */
std::string wrongExport(const ExportOptions& options);

/** Reads an avatar, poses it and writes its splats. General splats as input are converted without a pose. Returns lines to show the user:
 *  what the format cannot hold, counts and sizes, and the viewers that show the file upright. */
Result<std::string> exportPosedSplats(const ExportOptions& options);

}  // namespace dpl
