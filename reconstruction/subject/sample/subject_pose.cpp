// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/subject.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {
namespace {

constexpr double kStepS = 1.0 / 240;
constexpr double kHoldOffM = 0.003;

/** How far the arms are raised relative to the chest: 0 in the A-pose, about 1 overhead. Smooth. */
double armRaise(const Subject& subject, const std::vector<Mat3x4d>& g) {
    double sum = 0;
    const Mat3d chest(g[kSpine3][0], g[kSpine3][1], g[kSpine3][2]);
    for (int side = 0; side < 2; ++side) {
        const int shoulder = kLeftShoulder + side, elbow = kLeftElbow + side;
        const Vec3d rest(subject.joints[elbow].restPosition - subject.joints[shoulder].restPosition);
        const Mat3d turn(g[shoulder][0], g[shoulder][1], g[shoulder][2]);
        const Vec3d now = glm::transpose(chest) * (turn * glm::normalize(rest));
        const double t = std::clamp((now.y + 0.67) / 1.55, 0.0, 1.0);  // the A-pose has y = −0.67
        sum += t * t * (3 - 2 * t);
    }
    return 0.5 * sum;
}

/** Pushes a skirt out of the legs by kHoldOffM, and lets the cloth around follow softly. */
void pushOutOfLegs(const Subject& subject, std::vector<Vec3d>& at) {
    constexpr float kReachM = 0.08f, kLegsTopM = 0.95f;
    constexpr int kSpreadRounds = 12;
    const MeshData& mesh = subject.mesh;
    const LayerData &body = mesh.layers[0], &skirt = mesh.layers.back();
    std::vector<Vec3f> skin(at.begin(), at.begin() + body.vertexCount);
    std::vector<Triangle> legs;
    for (uint32_t t = 0; t < body.triangleCount; ++t) {
        const Triangle& f = mesh.triangles[t];
        const Vec3f& p = subject.canonical[f.x];
        if (p.y < kLegsTopM && std::abs(p.x) < 0.35f) legs.push_back(f);
    }
    const ClosestSurface surface(skin, legs);
    std::vector<Vec3d> push(skirt.vertexCount, Vec3d(0));
    for (uint32_t i = 0; i < skirt.vertexCount; ++i) {
        const Vec3f p(at[skirt.firstVertex + i]);
        const SurfacePoint near = surface.find(p, kReachM);
        if (!near.found() || subject.cloth[skirt.firstVertex + i].swing[0] == 0) continue;
        const double off = double(surface.signedDistance(p, kReachM));
        if (off < kHoldOffM) push[i] = Vec3d(near.position) + kHoldOffM * Vec3d(surface.normalAt(near)) - Vec3d(p);
    }
    std::vector<Triangle> faces(mesh.triangles.begin() + skirt.firstTriangle,
                                mesh.triangles.begin() + skirt.firstTriangle + skirt.triangleCount);
    for (Triangle& f : faces) f -= skirt.firstVertex;
    const auto neighbours = vertexNeighbours(skirt.vertexCount, faces);
    std::vector<Vec3d> spread = push;
    for (int round = 0; round < kSpreadRounds; ++round) {
        std::vector<Vec3d> next(spread.size(), Vec3d(0));
        for (size_t i = 0; i < next.size(); ++i) {
            for (uint32_t n : neighbours[i]) next[i] += spread[n] / double(neighbours[i].size());
            if (glm::dot(push[i], push[i]) > glm::dot(next[i], next[i])) next[i] = push[i];
            if (subject.cloth[skirt.firstVertex + i].swing[0] == 0) next[i] = Vec3d(0);
        }
        spread = std::move(next);
    }
    for (size_t i = 0; i < spread.size(); ++i) at[skirt.firstVertex + i] += spread[i];
}

}  // namespace

std::vector<Vec3d> poseSubject(const Subject& subject, const TruthPose& pose, const std::vector<Vec3d>* lag,
                               std::span<const LockNode> lockNodes) {
    const auto g = truthTransforms(subject.joints, pose);
    const MeshData& mesh = subject.mesh;
    std::vector<Vec3d> at(mesh.restPositions.size());
    for (size_t v = 0; v < at.size(); ++v) at[v] = skinned(g, mesh.jointIndices[v], mesh.jointWeights[v], Vec3d(mesh.restPositions[v]));
    if (!lag) return at;

    const LayerData& body = mesh.layers[0];
    std::vector<Vec3d> normals(body.vertexCount, Vec3d(0));
    for (uint32_t t = body.firstTriangle; t < body.firstTriangle + body.triangleCount; ++t) {
        const Triangle& f = mesh.triangles[t];
        const Vec3d n = glm::cross(at[f.y] - at[f.x], at[f.z] - at[f.x]);
        normals[f.x] += n, normals[f.y] += n, normals[f.z] += n;
    }
    const double raise = armRaise(subject, g);
    for (size_t v = 0; v < at.size(); ++v) {
        const ClothVertex& cloth = subject.cloth[v];
        if (cloth.slide == 0 && cloth.swing[0] == 0) continue;
        const Mat3x4d m = blendedTransform(mesh.jointIndices[v], mesh.jointWeights[v], g.data());
        at[v] += raise * double(cloth.slide) * glm::normalize(m[1]);  // up along the trunk
        for (int k = 0; k < 3; ++k) at[v] += double(cloth.swing[k]) * (*lag)[cloth.drivers[k]];
        const uint32_t a = subject.anchor[v];
        const double length = glm::length(normals[a]);
        if (length <= 0) continue;
        const Vec3d n = normals[a] / length;
        const double off = glm::dot(at[v] - at[a], n);
        // Deeper than 5 cm, the anchor is not the skin that lies below the cloth.
        if (off < kHoldOffM && off > -0.05) at[v] += (kHoldOffM - off) * n;
    }
    if (subject.bottom == Bottom::Skirt) pushOutOfLegs(subject, at);
    if (!lockNodes.empty()) placeLocks(subject.hair, lockNodes, at);
    return at;
}

std::vector<Vec3d> keypointsWorld(const Subject& subject, std::span<const BodyKeypoint> keypoints, const TruthPose& pose,
                                  const std::vector<Vec3d>& vertices) {
    const auto g = truthTransforms(subject.joints, pose);
    std::vector<Vec3d> out;
    for (const BodyKeypoint& k : keypoints) {
        Vec3d sum(0);
        for (const auto& [v, w] : k.vertices) sum += double(w) * vertices[v];
        for (const auto& [j, w] : k.joints) sum += double(w) * transformed(g[j], Vec3d(subject.joints[j].restPosition));
        out.push_back(sum);
    }
    return out;
}

SwingSimulation::SwingSimulation(const Subject& subject, const SampleMotion& motion) : subject_(subject), motion_(motion) {
    before_ = now_ = tracks(0);
    lag_.assign(subject.drivers.size(), Vec3d(0));
    speed_ = soft_ = lag_;
}

std::vector<Vec3d> SwingSimulation::tracks(double timeS) const {
    const auto g = truthTransforms(subject_.joints, motion_.pose(timeS));
    std::vector<Vec3d> out;
    for (const SwingDriver& d : subject_.drivers)
        out.push_back(skinned(g, subject_.mesh.jointIndices[d.vertex], subject_.mesh.jointWeights[d.vertex],
                              Vec3d(subject_.mesh.restPositions[d.vertex])));
    return out;
}

const std::vector<Vec3d>& SwingSimulation::at(double timeS) {
    const int64_t target = int64_t(std::llround(timeS / kStepS));
    for (; step_ < target; ++step_) {
        const std::vector<Vec3d> next = tracks(double(step_ + 1) * kStepS);
        for (size_t d = 0; d < lag_.size(); ++d) {
            const double w = 6.283185307179586 * double(subject_.drivers[d].frequencyHz), z = double(subject_.drivers[d].damping);
            const Vec3d acceleration = (next[d] - 2.0 * now_[d] + before_[d]) / (kStepS * kStepS);
            // Semi-implicit Euler is stable here: ω·dt is at most 0.045.
            speed_[d] += kStepS * (-w * w * lag_[d] - 2 * z * w * speed_[d] - acceleration);
            lag_[d] += kStepS * speed_[d];
        }
        before_ = now_;
        now_ = next;
    }
    for (size_t d = 0; d < lag_.size(); ++d) {  // limits the lag smoothly to the length of the cloth
        const double length = glm::length(lag_[d]), most = subject_.drivers[d].maxLagM;
        soft_[d] = length > 1e-9 ? lag_[d] * (most * std::tanh(length / most) / length) : Vec3d(0);
    }
    return soft_;
}

}  // namespace dpl
