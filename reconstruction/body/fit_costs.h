// SPDX-License-Identifier: Apache-2.0
// The residuals of the body fit. Only fit_*.cpp include this: Ceres stays out of public headers.
#pragma once

#include <ceres/cost_function.h>

#include <memory>
#include <vector>

#include "reconstruction/body/keypoint_chain.h"
#include "reconstruction/body/pose_prior.h"
#include "reconstruction/capture/scan.h"

namespace dpl {

/** Which pose parameters sway: their places in the sway block after its six root values. */
struct SwayLayout {
    std::vector<uint32_t> slots;  // index into KeypointChain::posedJoints
    int size() const { return kRootSize + 3 * int(slots.size()); }
};

/** Shared by all residuals of one fit; changed only between solves. */
struct FitContext {
    const KeypointChain* chain = nullptr;
    SwayLayout sway;
    double outlierSigmas = 4;
    double footSigmaScale = 1;  // widens FootRest while poses are still coarse; its saturated cost stays that of a final outlier
};

/** Two residuals a seen keypoint. Blocks: shape, log metres per unit, root, pose[, sway]. Geman–McClure inside: r·c/√(|r|²+c²), whose
 * square is ρ. */
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

/** Spread about `mean` (3 a joint) and range about the rest pose: 6 residuals a joint. Block: pose. */
class PosePriorCost final : public ceres::CostFunction {
public:
    PosePriorCost(std::vector<JointPrior> priors, std::vector<double> mean);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    std::vector<JointPrior> priors_;
    std::vector<double> mean_;
};

/** (x − mean)/σ for each parameter of one block. */
class DiagonalPrior final : public ceres::CostFunction {
public:
    DiagonalPrior(std::vector<double> mean, std::vector<double> sigma);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    std::vector<double> mean_, sigma_;
};

/** Standard normal prior on morph values, and a steep wall outside [min, max]. Block: shape. */
class ShapePrior final : public ceres::CostFunction {
public:
    explicit ShapePrior(const std::vector<ShapeMorph>& morphs);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    std::vector<double> low_, high_;
};

/** Angular acceleration of every posed joint over three frames at times t0 < t1 < t2. Blocks: pose0, pose1, pose2. */
class PoseSmoothness final : public ceres::CostFunction {
public:
    PoseSmoothness(std::vector<JointPrior> priors, double t0, double t1, double t2);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    std::vector<JointPrior> priors_;
    double weight_[3];  // of each pose in the acceleration
};

/** Acceleration of the root: turn (relative rotations, so any facing) and translation. Blocks: root0, root1, root2.
 *  `up`: the vertical, about which people turn faster than they tilt. */
ceres::CostFunction* makeRootSmoothness(const Mat3d (&references)[3], const Vec3d& up, double t0, double t1, double t2);

constexpr double kTurnAccelerationRadS2 = 2.0, kTiltAccelerationRadS2 = 0.15, kRootAccelerationMS2 = 0.6;

/** The pelvis stays about as upright as in the still pose: `bodyUp` (the root's own axis that points `up` there) against `up`. Block: root.
 */
ceres::CostFunction* makeRootUpright(const Mat3d& reference, const Vec3d& bodyUp, const Vec3d& up);
constexpr double kTiltRad = 0.04;

/** Feet that stand do not slide: the moves of ankles and toes between two frames, Geman–McClure, so a swinging foot is let go.
 *  With a moving camera this is what fixes the body's depth. Blocks: shape, root0, pose0, root1, pose1. */
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
constexpr double kFootOutlierSigmas = 3;

}  // namespace dpl
