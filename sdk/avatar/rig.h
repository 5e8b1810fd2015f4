// SPDX-License-Identifier: Apache-2.0
// Rig, pose and linear blend skinning. Formula: G_j = G_parent · [R_j | p_j − R_j p_j], v' = Σ_j w_j G_j v.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/motion_memory.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/expression_names.h"
#include "sdk/math/binding.h"

namespace dpl {

/** How strongly each expression of kExpressionNames is shown, 0 to 1. */
using ExpressionWeights = std::array<float, kExpressionCount>;

/** A pose of a rig: one local rotation per joint (about its rest position, relative to its parent) and the translation of the root, metres.
 *  And what cloth still holds, at the time of this pose, of the poses before it; all 0 where no time is known. And how stiff it is, and
 *  what the face shows. */
struct Pose {
    std::vector<Quatf> localRotations;
    Vec3f rootTranslation{0};
    MotionMemory before{};
    float clothStiffness = 1;  // 0 to kMostClothStiffness; 1: as learned
    ExpressionWeights expression{};

    static Pose rest(size_t jointCount) { return {std::vector<Quatf>(jointCount, Quatf(1, 0, 0, 0))}; }
};

/** World position of the root joint (joint 0, which must exist) in a pose. */
inline Vec3f rootPosition(std::span<const JointData> joints, const Pose& pose) {
    return joints[0].restPosition + pose.rootTranslation;
}

/** Refuses a wrong joint count, rotations that are zero or not finite (naming the joint), and a root translation beyond 100 km
 *  (InvalidArgument). */
Status checkPose(std::span<const JointData> joints, const Pose& pose);

/** Refuses a joint whose parent does not come first or whose rest position is not finite, and names it (CorruptData). */
Status checkRig(std::span<const JointData> joints);

/** worldFromRest[j] = G_j as [R | t]. Normalises the rotations. The pose must have passed checkPose. */
void jointTransforms(std::span<const JointData> joints, const Pose& pose, std::vector<Mat3x4f>& worldFromRest);

/** Skins `rest` (V positions) with the weights of `mesh`: four unorm8 per vertex. positions: V, world, resized. */
void skin(const MeshData& mesh, std::span<const Vec3f> rest, std::span<const Mat3x4f> worldFromRest, Jobs& jobs,
          std::vector<Vec3f>& positions);
/** The same for the mesh's own rest positions. */
inline void skin(const MeshData& mesh, std::span<const Mat3x4f> worldFromRest, Jobs& jobs, std::vector<Vec3f>& positions) {
    skin(mesh, mesh.restPositions, worldFromRest, jobs, positions);
}

/** Rest frames of all triangles. Those of degenerate triangles are marked invalid and carry no splats. */
std::vector<RestTriangle<float>> restTriangles(const MeshData& mesh);
/** The same into a vector that keeps its memory. */
void restTriangles(const MeshData& mesh, Jobs& jobs, std::vector<RestTriangle<float>>& rest);

/** Triangles at rest, as splats are bound to them and as their stretch is measured from them. */
struct TrianglesAtRest {
    std::span<const RestTriangle<float>> bind;      // splat sizes refer to them; empty: those of the mesh, which costs time in each pose
    std::span<const RestTriangle<float>> now = {};  // those of the mesh, where training has moved it since; empty: `bind`
};

/** Frames of all triangles as they are drawn (drawnTriangle). light: V brightness factors; empty: 1. */
void poseTriangles(const MeshData& mesh, const TrianglesAtRest& rest, std::span<const Vec3f> positions, Jobs& jobs,
                   std::vector<TriangleFrame<float>>& frames, std::span<const float> light = {});

}  // namespace dpl
