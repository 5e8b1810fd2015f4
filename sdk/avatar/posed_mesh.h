// SPDX-License-Identifier: Apache-2.0
// From a pose to posed triangles, in one place for the software renderer, the trainer and the exporters:
//   pose ─► correctives (offsets, light) ─► joint transforms ─► skin ─► triangle frames
#pragma once

#include <vector>

#include "sdk/avatar/pose_correctives.h"

namespace dpl {

/** What is posed, borrowed for the call. `bind`: the rest triangles that splat sizes refer to; empty: the mesh's own. */
struct PosedSubject {
    std::span<const JointData> joints;
    const MeshData& mesh;
    const PoseCorrectiveData& correctives;
    std::span<const RestTriangle<float>> bind;
};

/** A mesh in a pose. Keeps its buffers: posing again allocates nothing. One thread at a time. */
class PosedMesh {
public:
    /** The pose must have passed checkPose, the correctives checkCorrectives. */
    void pose(const PosedSubject& subject, const Pose& pose, Jobs& jobs) { control(subject, pose), surface(subject, jobs); }
    /** The first half, microseconds: joints and control nodes. Then the second, which is left out where nobody would see it: until then
     * frames and positions are those of before. */
    void control(const PosedSubject& subject, const Pose& pose);
    void surface(const PosedSubject& subject, Jobs& jobs);

    std::span<const TriangleFrame<float>> frames() const { return frames_; }
    std::span<const Vec3f> positions() const { return positions_; }            // V, world
    std::span<const Vec3f> rest() const { return moved_; }                     // V, what was skinned
    std::span<const float> light() const { return light_; }                    // V, or empty without correctives
    std::span<const Mat3x4f> worldFromRest() const { return worldFromRest_; }  // one a joint
    std::span<const float> coefficients() const { return coefficients_; }      // K
    std::span<const Vec4f> nodes() const { return nodes_; }                    // M

private:
    std::vector<float> coefficients_, light_;
    std::vector<Vec4f> nodes_;
    std::vector<Vec3f> moved_, positions_;
    std::vector<Mat3x4f> worldFromRest_;
    std::vector<TriangleFrame<float>> frames_;
};

}  // namespace dpl
