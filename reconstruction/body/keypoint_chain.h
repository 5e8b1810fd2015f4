// SPDX-License-Identifier: Apache-2.0
// Where a posed, shaped body's keypoints are, and how they move with shape and pose: the joint chain with the keypoint regressors baked in.
//
//   world rotation   W_j = W_parent · exp(w_j),  W_root = exp(w_root)·R_ref
//   joint place      P_j = P_parent + W_parent (p_j − p_parent),  P_root = p_root + t
//   keypoint         X_k = Σ_j W_j a_kj(β) + b_kj P_j      (a, p linear in β: morphs act on vertices and joints linearly)
//   turning joint j by ω (world):  dX_k = ω × Σ_{i below j} (W_i a_ki + b_ki (P_i − P_j))
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/body/body_model.h"

namespace dpl {

constexpr int kRootSize = 6;  // rotation vector, translation

/** exp of a rotation vector (Rodrigues). */
Mat3d rotationOf(const Vec3d& w);
/** Left Jacobian: exp(w + dw) = exp(J dw)·exp(w) to first order. */
Mat3d leftJacobian(const Vec3d& w);
/** The rotation vector of a rotation matrix, |w| ≤ π. */
Vec3d rotationVector(const Mat3d& r);

class KeypointChain {
public:
    /** `keypointNames`: the scan's; names that the body lacks are absent points. `posedJoints`: joints that turn, without the root. */
    KeypointChain(const BodyModel& body, std::span<const std::string> keypointNames, std::vector<uint32_t> posedJoints);

    size_t keypointCount() const { return keypoints_.size(); }
    size_t shapeCount() const { return shapeCount_; }
    size_t posedCount() const { return posedJoints_.size(); }
    std::span<const uint32_t> posedJoints() const { return posedJoints_; }
    bool hasKeypoint(size_t k) const { return !keypoints_[k].empty(); }
    /** Columns of a Jacobian row: root (6), pose (3 each posed joint), shape. */
    size_t columns() const { return kRootSize + 3 * posedCount() + shapeCount_; }

    struct Output {
        std::vector<Vec3d> points;     // K
        std::vector<double> jacobian;  // K × 3 rows × columns(), row-major; empty when not asked for
        std::vector<Mat3d> rotations;  // J, world
        std::vector<Vec3d> places;     // J, world
    };
    /** root: kRootSize, pose: 3·posedCount, shape: shapeCount. */
    void evaluate(const Mat3d& rootReference, const double* root, const double* pose, const double* shape, bool wantJacobian,
                  Output& out) const;

    /** Rest place of a joint at a shape. */
    Vec3d restPlace(size_t joint, const double* shape) const;

private:
    struct Contribution {
        uint32_t joint = 0;
        Vec3d offset{0};  // a at β = 0
        std::vector<Vec3d> offsetPerShape;
        double jointWeight = 0;  // b
    };
    size_t shapeCount_ = 0;
    std::vector<int32_t> parents_, slotOfJoint_;    // slot: index into posedJoints_, −1 still, −2 the root
    std::vector<Vec3d> rest_;                       // J
    std::vector<std::vector<Vec3d>> restPerShape_;  // J × shapes
    std::vector<uint32_t> posedJoints_;
    std::vector<std::vector<Contribution>> keypoints_;  // K
};

}  // namespace dpl
