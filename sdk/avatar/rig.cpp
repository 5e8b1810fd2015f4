// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/rig.h"

#include <algorithm>
#include <cmath>

#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr size_t kVertexGrain = 2048;  // vertices per block: small enough to balance threads, large enough to hide the cost of a block
constexpr size_t kTriangleGrain = 2048;
constexpr float kMinQuaternionNorm2 = 1e-12f;  // below this, the direction of the quaternion is rounding noise
constexpr float kMaxQuaternionNorm2 = 1e12f;   // above this, squares of ordinary products overflow
constexpr float kMaxRootTranslationM = 1e5f;   // 100 km; float resolves no millimetres beyond

bool finite(const Quatf& q) {
    return std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z) && std::isfinite(q.w);
}

Mat3x4f multiply(const Mat3x4f& a, const Mat3x4f& b) {
    const Mat3f ra(a[0], a[1], a[2]);
    return Mat3x4f(ra * b[0], ra * b[1], ra * b[2], ra * b[3] + a[3]);
}

}  // namespace

Status checkPose(std::span<const JointData> joints, const Pose& pose) {
    if (pose.localRotations.size() != joints.size())
        return fail(Code::InvalidArgument, "the pose has {} rotations, the rig has {} joints", pose.localRotations.size(), joints.size());
    for (size_t j = 0; j < joints.size(); ++j) {
        const Quatf& q = pose.localRotations[j];
        if (!finite(q))
            return fail(Code::InvalidArgument, "rotation of joint '{}' ({}) is not finite: [{}, {}, {}, {}]", joints[j].name, j, q.x, q.y,
                        q.z, q.w);
        const float norm2 = glm::dot(q, q);
        if (!(norm2 > kMinQuaternionNorm2) || !(norm2 < kMaxQuaternionNorm2))
            return fail(Code::InvalidArgument, "rotation of joint '{}' ({}) has length {}; a rotation is a unit quaternion (xyzw)",
                        joints[j].name, j, std::sqrt(norm2));
    }
    const Vec3f& t = pose.rootTranslation;
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(t[axis]) <= kMaxRootTranslationM))
            return fail(Code::InvalidArgument, "the root translation [{}, {}, {}] is not finite or is beyond {} m", t.x, t.y, t.z,
                        kMaxRootTranslationM);
    return {};
}

Status checkRig(std::span<const JointData> joints) {
    for (size_t j = 0; j < joints.size(); ++j) {
        const JointData& joint = joints[j];
        if (joint.parent < -1 || joint.parent >= int32_t(j))
            return fail(Code::CorruptData, "joint '{}' ({}) has parent {}; parents come first", joint.name, j, joint.parent);
        for (int axis = 0; axis < 3; ++axis)
            if (!std::isfinite(joint.restPosition[axis]))
                return fail(Code::CorruptData, "rest position of joint '{}' ({}) is not finite", joint.name, j);
    }
    return {};
}

void jointTransforms(std::span<const JointData> joints, const Pose& pose, std::vector<Mat3x4f>& worldFromRest) {
    worldFromRest.resize(joints.size());
    for (size_t j = 0; j < joints.size(); ++j) {
        const Mat3f rotation = glm::mat3_cast(glm::normalize(pose.localRotations[j]));
        const Vec3f& p = joints[j].restPosition;
        const Mat3x4f local(rotation[0], rotation[1], rotation[2], p - rotation * p);
        if (joints[j].parent < 0) {
            worldFromRest[j] = local;
            worldFromRest[j][3] += pose.rootTranslation;
        } else {
            worldFromRest[j] = multiply(worldFromRest[size_t(joints[j].parent)], local);
        }
    }
}

void skin(const MeshData& mesh, std::span<const Vec3f> restPositions, std::span<const Mat3x4f> worldFromRest, Jobs& jobs,
          std::vector<Vec3f>& positions) {
    positions.resize(restPositions.size());
    const auto body = [&](size_t begin, size_t end, uint32_t) {
        for (size_t v = begin; v < end; ++v)
            positions[v] = skinVertex(restPositions[v], mesh.jointIndices[v], mesh.jointWeights[v], worldFromRest.data());
    };
    jobs.forRange(positions.size(), kVertexGrain, body);
}

namespace {

RestTriangle<float> restTriangleOf(const MeshData& mesh, size_t t) {
    const Triangle& corner = mesh.triangles[t];
    return restTriangle(mesh.restPositions[corner.x], mesh.restPositions[corner.y], mesh.restPositions[corner.z]);
}

}  // namespace

std::vector<RestTriangle<float>> restTriangles(const MeshData& mesh) {
    std::vector<RestTriangle<float>> rest(mesh.triangles.size());
    for (size_t t = 0; t < rest.size(); ++t) rest[t] = restTriangleOf(mesh, t);
    return rest;
}

void restTriangles(const MeshData& mesh, Jobs& jobs, std::vector<RestTriangle<float>>& rest) {
    rest.resize(mesh.triangles.size());
    jobs.forRange(rest.size(), kTriangleGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t) rest[t] = restTriangleOf(mesh, t);
    });
}

namespace {

/** Whether the stretch of the plane lies within the bounds of boundedPlane() by more than rounding: then drawnTriangle() is poseTriangle(),
 *  at half the cost. By the singular values of F. */
bool clearlyWithinBounds(const RestInverse<float>& rest, const Vec3f& v0, const Vec3f& v1, const Vec3f& v2) {
    constexpr float kMargin = 1e-3f, kHigh = float(kStretchHigh) - kMargin, kLow = float(kStretchLow) + kMargin;
    const Vec3f d1 = v1 - v0, d2 = v2 - v0, f0 = rest.i00 * d1, f1 = rest.i01 * d1 + rest.i11 * d2;
    const float a = glm::dot(f0, f0), b = glm::dot(f0, f1), c = glm::dot(f1, f1);
    const float mean = 0.5f * (a + c), gap = std::sqrt(0.25f * (a - c) * (a - c) + b * b);
    return mean + gap < kHigh * kHigh && mean - gap > kLow * kLow;
}

}  // namespace

void poseTriangles(const MeshData& mesh, const TrianglesAtRest& rest, std::span<const Vec3f> positions, Jobs& jobs,
                   std::vector<TriangleFrame<float>>& frames, std::span<const float> light) {
    frames.resize(mesh.triangles.size());
    const auto body = [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t) {
            const Triangle& corner = mesh.triangles[t];
            const Vec3f &v0 = positions[corner.x], &v1 = positions[corner.y], &v2 = positions[corner.z];
            const RestTriangle<float> bind = rest.bind.empty() ? restTriangleOf(mesh, t) : rest.bind[t];
            const RestTriangle<float>& now = rest.now.empty() ? bind : rest.now[t];
            if (clearlyWithinBounds(now.valid ? now.inverse : bind.inverse, v0, v1, v2))
                frames[t] = poseTriangle(bind, v0, v1, v2);
            else
                frames[t] = rest.now.empty() ? drawnTriangle(bind, v0, v1, v2) : drawnTriangle(bind, rest.now[t], v0, v1, v2);
            if (!light.empty()) frames[t].light = {light[corner.x], light[corner.y], light[corner.z]};
        }
    };
    jobs.forRange(frames.size(), kTriangleGrain, body);
}

}  // namespace dpl
