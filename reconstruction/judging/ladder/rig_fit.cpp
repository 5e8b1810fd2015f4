// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/rig_fit.h"

#include <Eigen/Dense>
#include <algorithm>

#include "reconstruction/training/trainer/rotation_vector.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr double kPull = 1e-5;  // m²/rad²: a joint with one vertex 1 cm away already outweighs it tenfold
constexpr int kMaxSteps = 20;

struct Joints {
    std::vector<Mat3d> turned;  // world from rest, rotation
    std::vector<Vec3d> pivot;   // world place
};

Joints placed(std::span<const JointData> joints, const Pose& pose) {
    Joints out;
    for (size_t j = 0; j < joints.size(); ++j) {
        const Mat3d own = glm::mat3_cast(glm::normalize(Quatd(pose.localRotations[j])));
        const int32_t parent = joints[j].parent;
        if (parent < 0) {
            out.turned.push_back(own), out.pivot.push_back(Vec3d(joints[j].restPosition) + Vec3d(pose.rootTranslation));
            continue;
        }
        const size_t p = size_t(parent);
        const Vec3d bone = Vec3d(joints[j].restPosition) - Vec3d(joints[p].restPosition);
        out.pivot.push_back(out.pivot[p] + out.turned[p] * bone);
        out.turned.push_back(out.turned[p] * own);
    }
    return out;
}

/** One vertex moved by each of its joints: weight · G_j v. */
struct Part {
    size_t joint;
    double weight;
    Vec3d place;
};

size_t partsOf(std::span<const JointData> joints, const MeshData& mesh, size_t v, const Joints& at, Part parts[4]) {
    size_t count = 0;
    for (int k = 0; k < 4; ++k) {
        const double weight = mesh.jointWeights[v][k] / 255.0;
        if (weight == 0) continue;
        const size_t j = mesh.jointIndices[v][k];
        parts[count++] = {j, weight, at.pivot[j] + at.turned[j] * (Vec3d(mesh.restPositions[v]) - Vec3d(joints[j].restPosition))};
    }
    return count;
}

double costOf(std::span<const JointData> joints, const MeshData& mesh, std::span<const Vec3f> targets, std::span<const float> weights,
              const Pose& pose, const Pose& start) {
    const Joints at = placed(joints, pose);
    double cost = 0;
    for (size_t v = 0; v < targets.size(); ++v) {
        if (!(weights[v] > 0)) continue;
        Part parts[4];
        Vec3d sum = -Vec3d(targets[v]);
        for (size_t k = 0, n = partsOf(joints, mesh, v, at, parts); k < n; ++k) sum += parts[k].weight * parts[k].place;
        cost += weights[v] * glm::dot(sum, sum);
    }
    for (size_t j = 0; j < joints.size(); ++j) {
        const Vec3d turn =
            logQuaternion(glm::normalize(Quatd(pose.localRotations[j])) * glm::conjugate(glm::normalize(Quatd(start.localRotations[j]))));
        cost += kPull * glm::dot(turn, turn);
    }
    return cost;
}

}  // namespace

Pose fitRig(std::span<const JointData> joints, const MeshData& mesh, std::span<const Vec3f> targets, std::span<const float> weights,
            const Pose& start) {
    // Unknowns of a step: for each joint a small turn ω_j (world axes) of everything below it about its pivot, then the root's translation.
    const Eigen::Index size = Eigen::Index(3 * joints.size() + 3);
    Pose pose = start;
    double cost = costOf(joints, mesh, targets, weights, pose, start), damping = 1e-6;
    Eigen::MatrixXd normal(size, size);
    Eigen::VectorXd gradient(size);
    std::vector<std::pair<size_t, Vec3d>> arms;  // joints above a vertex, with Σ weight · (G v − pivot)
    for (int step = 0; step < kMaxSteps; ++step) {
        const Joints at = placed(joints, pose);
        normal.setZero(), gradient.setZero();
        for (size_t v = 0; v < targets.size(); ++v) {
            if (!(weights[v] > 0)) continue;
            Part parts[4];
            const size_t count = partsOf(joints, mesh, v, at, parts);
            Vec3d residual = -Vec3d(targets[v]);
            arms.clear();
            for (size_t k = 0; k < count; ++k) {
                residual += parts[k].weight * parts[k].place;
                for (int32_t j = int32_t(parts[k].joint); j >= 0; j = joints[size_t(j)].parent) {
                    auto found = std::find_if(arms.begin(), arms.end(), [j](const auto& arm) { return arm.first == size_t(j); });
                    if (found == arms.end()) found = arms.insert(arms.end(), {size_t(j), Vec3d(0)});
                    found->second += parts[k].weight * (parts[k].place - at.pivot[size_t(j)]);
                }
            }
            // ∂residual/∂ω_j = −[arm_j]×, so for two joints the block is [a]×ᵀ[b]× = (a·b) I − b aᵀ, and Jᵀr = arm × r.
            const double w = weights[v];
            const Eigen::Index root = size - 3;
            for (const auto& [i, a] : arms) {
                const Vec3d pull = glm::cross(a, residual);
                for (int r = 0; r < 3; ++r) gradient[Eigen::Index(3 * i) + r] += w * pull[r];
                for (const auto& [j, b] : arms) {
                    if (j > i) continue;
                    const double ab = glm::dot(a, b);
                    for (int r = 0; r < 3; ++r)
                        for (int c = 0; c < 3; ++c)
                            normal(Eigen::Index(3 * i) + r, Eigen::Index(3 * j) + c) += w * ((r == c ? ab : 0.0) - b[r] * a[c]);
                }
                // Rows of the translation: I · (−[a]×).
                const double cross[3][3] = {{0, a.z, -a.y}, {-a.z, 0, a.x}, {a.y, -a.x, 0}};
                for (int r = 0; r < 3; ++r)
                    for (int c = 0; c < 3; ++c) normal(root + r, Eigen::Index(3 * i) + c) += w * cross[r][c];
            }
            for (int r = 0; r < 3; ++r) normal(root + r, root + r) += w, gradient[root + r] += w * residual[r];
        }
        for (size_t j = 0; j < joints.size(); ++j) {
            // The turn from the start in world axes; to first order a step ω adds to it.
            const Vec3d local = logQuaternion(glm::normalize(Quatd(pose.localRotations[j])) *
                                              glm::conjugate(glm::normalize(Quatd(start.localRotations[j]))));
            const int32_t parent = joints[j].parent;
            const Vec3d turn = parent < 0 ? local : at.turned[size_t(parent)] * local;
            for (int r = 0; r < 3; ++r) {
                normal(Eigen::Index(3 * j) + r, Eigen::Index(3 * j) + r) += kPull;
                gradient[Eigen::Index(3 * j) + r] += kPull * turn[r];
            }
        }
        bool lowered = false;
        for (int attempt = 0; attempt < 6 && !lowered; ++attempt) {
            Eigen::MatrixXd damped = normal;
            damped.diagonal() *= 1 + damping;
            const Eigen::VectorXd delta = -damped.selfadjointView<Eigen::Lower>().ldlt().solve(gradient);
            Pose next = pose;
            for (size_t j = 0; j < joints.size(); ++j) {
                const Vec3d world(delta[Eigen::Index(3 * j)], delta[Eigen::Index(3 * j) + 1], delta[Eigen::Index(3 * j) + 2]);
                const int32_t parent = joints[j].parent;
                const Vec3d local = parent < 0 ? world : glm::transpose(at.turned[size_t(parent)]) * world;
                next.localRotations[j] = Quatf(glm::normalize(turnQuaternion(local) * Quatd(pose.localRotations[j])));
            }
            for (int c = 0; c < 3; ++c) next.rootTranslation[c] += float(delta[size - 3 + c]);
            const double nextCost = costOf(joints, mesh, targets, weights, next, start);
            if (nextCost < cost) {
                lowered = true;
                const bool done = nextCost > cost * (1 - 1e-6);
                pose = std::move(next), cost = nextCost, damping = std::max(1e-9, damping * 0.1);
                if (done) return pose;
            } else {
                damping = std::max(1e-6, damping * 100);
            }
        }
        if (!lowered) break;
    }
    return pose;
}

}  // namespace dpl
