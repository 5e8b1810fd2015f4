// SPDX-License-Identifier: Apache-2.0
// Parses and checks the files of MakeHuman / MPFB2. makehuman.cpp makes a body of them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

/** base.obj: all positions in decimetres, the polygons and the vertices of every group. */
struct MakeHumanMesh {
    std::vector<Vec3f> positionsDm;
    std::map<std::string, std::vector<std::vector<uint32_t>>> faces;  // group name -> its polygons, 3 or 4 indices each
    std::map<std::string, std::vector<uint32_t>> groups;              // group name -> its vertices, ascending, no repeats
};
Result<MakeHumanMesh> readMakeHumanObj(const std::filesystem::path& path);

struct TargetRow {
    uint32_t vertex = 0;
    Vec3f offsetDm{0};
};
/** Reads a `.target` or `.target.gz` file. A vertex index ≥ `vertexCount` is an error; an empty file moves nothing. */
Result<std::vector<TargetRow>> readMakeHumanTarget(const std::filesystem::path& path, size_t vertexCount);

struct MakeHumanBone {
    std::string name, parent;            // parent "" for a root
    std::vector<uint32_t> headVertices;  // their mean is the joint's position
};
struct MakeHumanRig {
    std::vector<MakeHumanBone> bones;                                        // parents first
    std::map<std::string, std::vector<std::pair<uint32_t, float>>> weights;  // bone -> (vertex, weight)
};
Result<MakeHumanRig> readMakeHumanRig(const std::filesystem::path& rigPath, const std::filesystem::path& weightsPath,
                                      const MakeHumanMesh& mesh);

/** Joints of the face and what moves with the jaw, from MakeHuman's default rig. */
struct MakeHumanFaceRig {
    std::vector<uint32_t> leftEye, rightEye, jaw;  // their mean is the joint's position
    std::map<uint32_t, float> withJaw;             // vertex -> share of its weights on the jaw and what hangs on it, 0 to 1
};
/** Reads default.mhskel and default_weights.mhw in `folder`. */
Result<MakeHumanFaceRig> readMakeHumanFaceRig(const std::filesystem::path& folder, const MakeHumanMesh& mesh);

}  // namespace dpl
