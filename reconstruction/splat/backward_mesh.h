// SPDX-License-Identifier: Apache-2.0
// From gradients on posed vertices to the rest mesh, the pose and the camera (docs/reference/binding.md).
//
// A joint that turns by ω about its place moves every point it carries by W×(x − q), W = ω in world axes, q the joint in the world.
// So all joint gradients are torques: sums of x×g over what hangs on the joint. The camera's are the same sums over everything.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Vertex -> (triangle, corner) incidences in triangle order: the fixed order in which triangle gradients are gathered. */
struct VertexIncidence {
    std::vector<uint32_t> offset;   // V+1
    std::vector<uint32_t> corners;  // 3·triangle + corner

    VertexIncidence() = default;
    VertexIncidence(std::span<const Triangle> triangles, size_t vertexCount);
};

/** ∂loss/∂pose. rotation[j]: along the axes of joint j's parent frame, for R_j ← exp(ω)·R_j. */
template <class T>
struct PoseGradient {
    std::vector<Vec3<T>> rotation;
    Vec3<T> rootTranslation{0};
    Vec3<T> cameraRotation{0}, cameraTranslation{0};  // view frame, X_view ← exp(ω)·X_view + τ
};

/** One vertex: rest gradient out, and its share of every joint's force and torque about the world's origin. */
template <class T>
struct JointWrench {
    Vec3<T> force{0}, torque{0};
};

/** Gradient on the rest vertex: (Σ w G)ᵀ g. Adds w·g and (G_k v)×g·w to the wrench of each joint. weights: sum to 1. */
template <class T>
inline Vec3<T> backwardSkinVertex(const Vec3<T>& rest, const Vec3<T>& g, const glm::u16vec4& joints, const T weights[4],
                                  const Mat3x4<T>* worldFromRest, JointWrench<T>* wrench) {
    Vec3<T> out(0);
    for (int i = 0; i < 4; ++i) {
        if (weights[i] == T(0)) continue;
        const Mat3x4<T>& m = worldFromRest[joints[i]];
        const Vec3<T> moved = m[0] * rest.x + m[1] * rest.y + m[2] * rest.z + m[3];
        const Vec3<T> wg = weights[i] * g;
        out += Vec3<T>(glm::dot(m[0], wg), glm::dot(m[1], wg), glm::dot(m[2], wg));
        if (wrench) {
            wrench[joints[i]].force += wg;
            wrench[joints[i]].torque += glm::cross(moved, wg);
        }
    }
    return out;
}

/** Joint wrenches (own vertices only; overwritten by subtree sums) -> rotation and root gradients. */
template <class T>
inline void backwardJoints(std::span<const JointData> joints, std::span<const Mat3x4<T>> worldFromRest, std::vector<JointWrench<T>>& wrench,
                           PoseGradient<T>& out) {
    out.rotation.assign(joints.size(), Vec3<T>(0));
    out.rootTranslation = Vec3<T>(0);
    for (size_t k = joints.size(); k-- > 0;) {
        const int32_t parent = joints[k].parent;
        const Vec3<T> p(joints[k].restPosition);
        Vec3<T> q = p;  // the joint in the world: where the parent's transform puts it
        const Mat3x4<T>& own = worldFromRest[k];
        q = own[0] * p.x + own[1] * p.y + own[2] * p.z + own[3];
        const Vec3<T> about = wrench[k].torque - glm::cross(q, wrench[k].force);
        if (parent >= 0) {
            const Mat3x4<T>& m = worldFromRest[size_t(parent)];
            out.rotation[k] = {glm::dot(m[0], about), glm::dot(m[1], about), glm::dot(m[2], about)};
            wrench[size_t(parent)].force += wrench[k].force, wrench[size_t(parent)].torque += wrench[k].torque;
        } else {
            out.rotation[k] = about;
            out.rootTranslation += wrench[k].force;
        }
    }
}

/** The whole mesh in fixed blocks of vertices, reduced in block order. rest: the rest positions that were skinned. posed: their
 *  skinned places. gPosed: gradient on them. gRest is resized to V. The camera part needs the view rotation and translation. */
void backwardSkin(const MeshData& mesh, std::span<const Vec3f> rest, std::span<const JointData> joints,
                  std::span<const Mat3x4f> worldFromRest, std::span<const Vec3f> posed, std::span<const Vec3f> gPosed,
                  const Mat3f& viewRotation, const Vec3f& viewTranslation, Jobs& jobs, std::vector<Vec3f>& gRest,
                  PoseGradient<double>& pose);

}  // namespace dpl
