// SPDX-License-Identifier: Apache-2.0
// From gradients on posed vertices to gradients on the rest mesh and the pose (docs/reference/binding.md).
//
// A joint at world position q that turns by ω (world axes) moves each point x of its subtree by ω×(x − q). The gradient on ω is therefore
// the torque Σ (x − q)×g over the points of the subtree.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** For each vertex the corners of triangles that lie on it, in triangle order. Gradients are summed in this fixed order. */
struct VertexIncidence {
    std::vector<uint32_t> offset;   // V+1
    std::vector<uint32_t> corners;  // 3·triangle + corner

    VertexIncidence() = default;
    VertexIncidence(std::span<const Triangle> triangles, size_t vertexCount);
};

/** ∂loss/∂pose. rotation[j] belongs to R_j ← exp(ω)·R_j, with ω along the axes of the parent's frame. */
template <class T>
struct PoseGradient {
    std::vector<Vec3<T>> rotation;
    Vec3<T> rootTranslation{0};
};

/** Force and torque on one joint, world axes; the torque is about the world's origin. */
template <class T>
struct JointWrench {
    Vec3<T> force{0}, torque{0};
};

/** Returns the gradient on a rest vertex, (Σ w_k G_k)ᵀ g. Adds force w_k·g and torque (G_k v)×(w_k·g) to the wrench of each joint k, unless
 *  `wrench` is null. The weights sum to 1. */
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

/** Rotation and root gradients from the wrenches of the joints. On entry a wrench covers the joint's own vertices; the call overwrites it
 *  with the sum over the joint's subtree. */
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

/** Backward pass of skinning for the whole posed mesh. The sums run over fixed blocks of vertices in block order, so they do not depend on
 *  the number of threads. gPosed: gradient on posed.positions(). gRest, on posed.rest(), is resized to V. */
void backwardSkin(const MeshData& mesh, std::span<const JointData> joints, const PosedMesh& posed, std::span<const Vec3f> gPosed,
                  Jobs& jobs, std::vector<Vec3f>& gRest, PoseGradient<double>& pose);

}  // namespace dpl
