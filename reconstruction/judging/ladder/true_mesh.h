// SPDX-License-Identifier: Apache-2.0
// The true surface of a synthetic scan (docs/formats/scan.md, "for measuring only"): template, skin weights, poses and posed vertices.
// Nothing that makes an avatar includes this file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

/** The truth of one frame. Rotations are about the joints' rest positions and relative to their parents, axes parallel to the world. */
struct TrueFrame {
    bool known = false;            // false: truth.json does not list the frame
    std::vector<Quatd> rotations;  // one a joint
    Vec3d translation{0};          // of the root, metres
    std::filesystem::path posed;   // true vertices; empty: only the skinning is known
};

/** A part of the true template: a contiguous range of its triangles. */
struct TruePart {
    std::string label;  // as in the label pictures, "top" for example
    uint32_t firstTriangle = 0, triangleCount = 0;
    bool cloth = false;  // moved by a simulation
};

/** The true template and its poses, in the y-up world, metres. */
struct TrueMesh {
    std::vector<Vec3d> joints;           // rest positions
    std::vector<int32_t> parents;        // -1: root; parents come first
    std::vector<Vec3f> restPositions;    // V
    std::vector<Triangle> triangles;     // F
    std::vector<uint8_t> hidden;         // F; 1: left out of the pictures
    std::vector<uint8_t> clothTriangle;  // F; 1: moved by a simulation, so its skinning is not the truth in moving frames
    std::vector<TruePart> parts;         // may leave triangles out
    uint32_t influences = 0;             // K
    std::vector<int32_t> weightJoints;   // V·K
    std::vector<float> weights;          // V·K
    std::vector<TrueFrame> frames;       // of Scan::frames
};

/** Reads the truth of a scan. None when the scan has no truth.json or no geometry. CorruptData names the file and what is wrong with it. */
Result<std::optional<TrueMesh>> readTrueMesh(const Scan& scan);

/** The template skinned to a frame, V positions. Exact for still frames; in moving frames exact for all but cloth. */
std::vector<Vec3f> skinnedTruth(const TrueMesh& mesh, const TrueFrame& frame);

/** The true vertices of a frame, V positions: the skinning of a still frame, the posed file of a moving one. None when they are not
 *  known. */
Result<std::optional<std::vector<Vec3f>>> trueSurface(const TrueMesh& mesh, const TrueFrame& frame, FrameKind kind);

/** Whether the truth of a scan, if it has one, can be read: the mesh and the positions of every moving frame. A run looks at it before it
 *  trains, because its report needs it at the end. Errors name the file. */
Status checkTruth(const Scan& scan);

}  // namespace dpl
