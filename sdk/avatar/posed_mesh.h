// SPDX-License-Identifier: Apache-2.0
// From a pose to posed triangles, shared by the software renderer, the trainer and the exporters:
//   pose ─► correctives (offsets, light) ─► joint transforms ─► skin ─► light of the scene ─► triangle frames
#pragma once

#include <vector>

#include "sdk/avatar/cloth_limits.h"
#include "sdk/avatar/pose_correctives.h"

namespace dpl {

/** An avatar to pose, borrowed for the call. */
struct PosedSubject {
    std::span<const JointData> joints;
    const MeshData& mesh;
    const PoseCorrectiveData& correctives;
    TrianglesAtRest rest;
    const LightData* light = nullptr;             // null: none
    std::span<const Vec3f> normals = {};          // V, of RestNormals; empty: computed in each pose that needs them, which costs time
    const ClothLimits* cloth = nullptr;           // of the same avatar; null: clothes may enter the body, and tear
    const ExpressionData* expressions = nullptr;  // null: none
};

/** Whether both give the same mesh. */
bool samePose(const Pose& a, const Pose& b);

/** A mesh in a pose. It keeps its buffers, so posing again allocates nothing. One thread at a time. */
class PosedMesh {
public:
    /** The pose must have passed checkPose, the correctives checkCorrectives. */
    void pose(const PosedSubject& subject, const Pose& pose, Jobs& jobs) { control(subject, pose), surface(subject, jobs); }
    /** pose() for those who make the triangles' frames themselves: frames() are those of an earlier pose. */
    void poseVertices(const PosedSubject& subject, const Pose& pose, Jobs& jobs) {
        control(subject, pose), vertices(subject, jobs), addSceneLight(subject, jobs);
    }
    /** First half of pose(): joints and control nodes. Takes microseconds. */
    void control(const PosedSubject& subject, const Pose& pose);
    /** Second half: vertices and triangles. Callers skip it for an avatar that no view shows; frames() and positions() are then those of
     *  the earlier pose. */
    void surface(const PosedSubject& subject, Jobs& jobs);
    /** The part of surface() that gives positions(), rest() and light() without that of the scene: for those who need no triangle frames.
     */
    void vertices(const PosedSubject& subject, Jobs& jobs);

    /** After surface(): no splat of these triangles is drawn, until the next surface(). */
    void hideTriangles(size_t first, size_t count) {
        for (size_t t = first; t < first + count; ++t) frames_[t].valid = false;
    }

    std::span<const TriangleFrame<float>> frames() const { return frames_; }
    std::span<const Vec3f> positions() const { return positions_; }            // V, world
    std::span<const Vec3f> rest() const { return moved_; }                     // V, rest positions with correctives, before skinning
    std::span<const float> light() const { return light_; }                    // V brightness factors; empty: 1
    std::span<const float> sceneLight() const { return scene_; }               // V, their part of the light of the scene; empty: 1
    std::span<const Mat3x4f> worldFromRest() const { return worldFromRest_; }  // one per joint
    std::span<const float> coefficients() const { return coefficients_; }      // K + K' of the correctives, S of the expressions
    std::span<const Vec4f> nodes() const { return nodes_; }                    // M, of the correctives, within the limits of cloth
    float pushedM() const { return pushedM_; }                                 // by how much at most

private:
    void addSceneLight(const PosedSubject& subject, Jobs& jobs);

    float pushedM_ = 0;
    std::vector<float> coefficients_, light_, scene_;
    std::vector<Vec4f> nodes_;
    std::vector<Vec3f> moved_, positions_, normals_;
    ClothScratch cloth_;
    std::vector<Mat3x4f> worldFromRest_;
    std::vector<TriangleFrame<float>> frames_;
};

}  // namespace dpl
