// SPDX-License-Identifier: Apache-2.0
// Rig, pose and linear blend skinning. Formula: G_j = G_parent · [R_j | p_j − R_j p_j], v' = Σ_j w_j G_j v.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/binding.h"

namespace dpl {

/** A pose of a rig: one local rotation a joint (about its rest position, relative to its parent) and the root's translation, metres. */
struct Pose {
    std::vector<Quatf> localRotations;
    Vec3f rootTranslation{0};

    static Pose rest(size_t jointCount) { return {std::vector<Quatf>(jointCount, Quatf(1, 0, 0, 0)), Vec3f(0)}; }
};

/** Where the root joint (joint 0, which must exist) of a pose is, world. */
inline Vec3f rootPosition(std::span<const JointData> joints, const Pose& pose) {
    return joints[0].restPosition + pose.rootTranslation;
}

/** Refuses a wrong joint count and non-finite or zero rotations, naming the joint. */
Status checkPose(std::span<const JointData> joints, const Pose& pose);

/** Refuses parents that do not come first and rest positions that are not finite, naming the joint (CorruptData). */
Status checkRig(std::span<const JointData> joints);

/** worldFromRest[j] = G_j as [R | t]. Rotations are normalised here. The pose must have passed checkPose. */
void jointTransforms(std::span<const JointData> joints, const Pose& pose, std::vector<Mat3x4f>& worldFromRest);

/** Skins `rest` (V positions) with the four unorm8 weights of each vertex of `mesh`. `positions` is resized to V. */
void skin(const MeshData& mesh, std::span<const Vec3f> rest, std::span<const Mat3x4f> worldFromRest, Jobs& jobs,
          std::vector<Vec3f>& positions);
/** The same for the mesh's own rest positions. */
inline void skin(const MeshData& mesh, std::span<const Mat3x4f> worldFromRest, Jobs& jobs, std::vector<Vec3f>& positions) {
    skin(mesh, mesh.restPositions, worldFromRest, jobs, positions);
}

/** Rest frames of all triangles; invalid ones carry no splats. */
std::vector<RestTriangle<float>> restTriangles(const MeshData& mesh);

/** Posed frames of all triangles. rest: restTriangles, or empty: made on the way from the mesh's rest positions, so that nobody must keep
 *  52 bytes a triangle. light: brightness a vertex, or empty for 1. */
void poseTriangles(const MeshData& mesh, std::span<const RestTriangle<float>> rest, std::span<const Vec3f> positions, Jobs& jobs,
                   std::vector<TriangleFrame<float>>& frames, std::span<const float> light = {});

}  // namespace dpl
