// SPDX-License-Identifier: Apache-2.0
// Positions of a body's keypoints for a shape and a pose, and their derivatives. The skin weights and the morphs are folded into a few
// terms per keypoint and joint, so that no vertex is touched during the fit.
//
//   world rotation   W_j = W_parent · exp(w_j),  W_root = exp(w_root)·R_ref
//   joint position    P_j = P_parent + W_parent (p_j − p_parent),  P_root = p_root + t
//   keypoint         X_k = Σ_j W_j a_kj(β) + b_kj P_j      (a, p linear in β: morphs act on vertices and joints linearly)
//   rotating joint j by ω (world):  dX_k = ω × Σ_{i below j} (W_i a_ki + b_ki (P_i − P_j))
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/body/body_model.h"

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
    /** `keypointNames`: those of the scan; hasKeypoint() is false for a name that the body lacks. `posedJoints`: joints that may rotate,
     *  without the root. */
    KeypointChain(const BodyModel& body, std::span<const std::string> keypointNames, std::vector<uint32_t> posedJoints);

    size_t keypointCount() const { return keypoints_.size(); }
    size_t shapeCount() const { return shapeCount_; }
    size_t posedCount() const { return posedJoints_.size(); }
    std::span<const uint32_t> posedJoints() const { return posedJoints_; }
    int32_t parent(size_t joint) const { return parents_[joint]; }
    /** First column of a joint's rotation in the Jacobian; −1: the joint does not rotate. */
    int32_t columnOf(size_t joint) const {
        const int32_t slot = slotOfJoint_[joint];
        return slot == -2 ? 0 : slot < 0 ? -1 : kRootSize + 3 * slot;
    }
    bool hasKeypoint(size_t k) const { return !keypoints_[k].empty(); }
    /** The joint that carries most of keypoint k, which the body must have. */
    uint32_t carrier(size_t k) const;
    /** Moves keypoint k by `offset`, metres in the rest frame of its carrier: X_k gains W_carrier · offset. Replaces an earlier offset. */
    void setOffset(size_t k, const Vec3d& offset) { offsets_[k] = offset; }
    const Vec3d& offset(size_t k) const { return offsets_[k]; }
    /** Number of columns of the Jacobian: root (6), pose (3 per posed joint), shape, in this order. */
    size_t columns() const { return kRootSize + 3 * posedCount() + shapeCount_; }

    struct Output {
        std::vector<Vec3d> points;     // one per keypoint, world, metres
        std::vector<double> jacobian;  // 3 rows per keypoint × columns(), row-major; empty unless asked for
        std::vector<Mat3d> rotations;  // one per joint, world
        std::vector<Vec3d> places;     // one per joint, world, metres
        std::vector<Mat3d> turns;      // one per joint: world rotation per unit of the joint's parameters; empty without the Jacobian
    };
    /** Reads kRootSize values of root, 3·posedCount() of pose and shapeCount() of shape. `held`: local rotations of all joints, read where
     * a joint is not posed, a finger's for example; empty: those are at rest. */
    void evaluate(const Mat3d& rootReference, const double* root, const double* pose, const double* shape, bool wantJacobian, Output& out,
                  std::span<const Mat3d> held = {}) const;

    /** Rest position of a joint for a shape, metres. */
    Vec3d restPlace(size_t joint, const double* shape) const;

private:
    struct Contribution {
        uint32_t joint = 0;
        Vec3d offset{0};  // a at β = 0
        std::vector<Vec3d> offsetPerShape;
        double jointWeight = 0;  // b
    };
    size_t shapeCount_ = 0;
    std::vector<int32_t> parents_, slotOfJoint_;    // slot: index into posedJoints_; −1: does not rotate, −2: the root
    std::vector<Vec3d> rest_;                       // J
    std::vector<std::vector<Vec3d>> restPerShape_;  // J × shapes
    std::vector<uint32_t> posedJoints_;
    std::vector<std::vector<Contribution>> keypoints_;  // K
    std::vector<Vec3d> offsets_;                        // K
};

}  // namespace dpl
