// SPDX-License-Identifier: Apache-2.0
// The residuals of the body fit. Private to reconstruction/subject/body and reconstruction/subject/registration, so that no public header
// includes Ceres. "Block" means a Ceres parameter block; each class lists its blocks in order.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <memory>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/body/keypoint_chain.h"
#include "reconstruction/subject/body/pose_prior.h"

namespace dpl {

/** Options of every solve: one thread and no BLAS, so that the bytes are equal on every machine. */
ceres::Solver::Options solverOptions(int maxSteps);

/** Appends the blocks of a pose: three values for each posed joint, because the priors and accelerations of a joint know no other joint,
 * and the solver multiplies the zeros of a larger block. */
inline void addPoseBlocks(std::vector<double*>& blocks, double* pose, size_t joints) {
    for (size_t j = 0; j < joints; ++j) blocks.push_back(pose + 3 * j);
}
inline void addPoseBlockSizes(std::vector<int32_t>& sizes, size_t joints) {
    sizes.insert(sizes.end(), joints, 3);
}
/** The pose in the blocks from `blocks` on. */
std::vector<double> poseOfBlocks(double const* const* blocks, size_t joints);
/** Copies columns of a row, three for each joint, into that row of the pose's Jacobians. */
void setPoseRow(double* const* jacobians, size_t row, const double* columns, size_t joints);
/** Holds a pose in its place, as far as the problem knows it. */
void holdPose(ceres::Problem& problem, std::vector<double>& pose);

/** Layout of a sway block: six root values, then three values for each joint that sways. */
struct SwayLayout {
    std::vector<uint32_t> slots;  // joints that sway, indices into KeypointChain::posedJoints()
    int size() const { return kRootSize + 3 * int(slots.size()); }
};

/** Shared by all residuals of one fit, which keep references to it. Changed only between solves. */
struct FitContext {
    const KeypointChain* chain = nullptr;
    SwayLayout sway;
    double outlierSigmas = 4;
    double footSigmaScale = 1;  // > 1 widens the σ of FootRest for coarse poses; its saturated cost stays the same
};

/** Two residuals per seen keypoint. Blocks: shape, log metres per unit, root, those of the pose[, sway]. The Geman–McClure loss is applied
 * inside: the residual r·c/√(|r|²+c²) has the square ρ. */
class ReprojectionCost final : public ceres::CostFunction {
public:
    ReprojectionCost(const FitContext& context, const Camerad& camera, const Mat3d& rootReference, const std::vector<Keypoint>& keypoints,
                     double sigmaPx, bool withSway);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    const FitContext& context_;
    Camerad camera_;
    Mat3d rootReference_;
    std::vector<Keypoint> keypoints_;
    std::vector<size_t> seen_;
    double sigmaPx_;
    bool withSway_;
};

/** Six residuals: three for the distance of a joint from `mean`, three for the part beyond the joint's range. Block: the joint's. */
class JointPriorCost final : public ceres::SizedCostFunction<6, 3> {
public:
    JointPriorCost(const JointPrior& prior, const Vec3d& mean);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    JointPrior prior_;
    Vec3d mean_;
};
/** One for each joint of a pose. mean: three values for each. */
void addPosePrior(ceres::Problem& problem, const std::vector<JointPrior>& priors, const std::vector<double>& mean, double* pose);

/** (x − mean)/σ for each parameter of one block. */
class DiagonalPrior final : public ceres::CostFunction {
public:
    DiagonalPrior(std::vector<double> mean, std::vector<double> sigma);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    std::vector<double> mean_, sigma_;
};
/** One for each joint of a pose. mean, sigma: three values for each. */
void addDiagonalPosePrior(ceres::Problem& problem, const std::vector<double>& mean, const std::vector<double>& sigma, double* pose);

/** Standard normal prior on each morph value, and a steep cost outside [minValue, maxValue]. Block: shape. */
class ShapePrior final : public ceres::CostFunction {
public:
    explicit ShapePrior(const std::vector<ShapeMorph>& morphs);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    std::vector<double> low_, high_;
};

/** How accelerations spread. People mostly move evenly and sometimes start or stop: with `tail` the spread is Cauchy's, whose scale is
 *  `share` of the standard deviation of the Gaussian. */
struct AccelerationSpread {
    bool tail = false;
    double share = 1;
};

/** Angular acceleration of a joint over frames at times t0 < t1 < t2, seconds. Blocks: the joint's in each of them. */
class JointSmoothness final : public ceres::SizedCostFunction<3, 3, 3, 3> {
public:
    JointSmoothness(const JointPrior& prior, double t0, double t1, double t2, AccelerationSpread spread = {});
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    double accelerationRadS2_;
    double weight_[3];  // coefficient of each pose in the acceleration, 1/s²
    AccelerationSpread spread_;
};

/** Angular and linear acceleration of the root. Relative rotations make it independent of the facing. People turn about `up`, the
 *  vertical, faster than they tilt, so the two have separate σ. Blocks: root0, root1, root2. The caller owns the result. */
ceres::CostFunction* makeRootSmoothness(const Mat3d (&references)[3], const Vec3d& up, double t0, double t1, double t2,
                                        AccelerationSpread spread = {});

/** Keeps the pelvis about as upright as in the still pose. `bodyUp` is the axis of the root's frame that points along `up`, the vertical,
 *  in the still pose. Block: root. The caller owns the result. */
ceres::CostFunction* makeRootUpright(const Mat3d& reference, const Vec3d& bodyUp, const Vec3d& up);

/** Keeps a standing foot in place: penalises the motion of ankles and toes between two frames. The Geman–McClure loss releases a swinging
 *  foot. This term fixes the body's depth when the camera moves. Blocks: shape, root0, those of pose0, root1, those of
 *  pose1. */
class FootRest final : public ceres::CostFunction {
public:
    FootRest(const FitContext& context, std::vector<size_t> keypoints, const Mat3d& reference0, const Mat3d& reference1, double sigmaM);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    const FitContext& context_;
    std::vector<size_t> keypoints_;
    Mat3d reference_[2];
    double sigmaM_;
};

}  // namespace dpl
