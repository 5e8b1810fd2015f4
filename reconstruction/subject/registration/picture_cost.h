// SPDX-License-Identifier: Apache-2.0
// Compares one picture with the surface that it shows: contrast of surface points, and outlines. A Ceres cost of one frame.
// Private to reconstruction/subject/registration.
#pragma once

#include <ceres/cost_function.h>

#include "reconstruction/subject/registration/frame_features.h"
#include "reconstruction/subject/registration/surface_points.h"

namespace dpl {

/** A point whose contrast is known from the still pictures. */
struct ContrastTerm {
    CarriedPoint point;
    Vec3d contrast{0};
    double sigma = 1;   // standard deviation of one channel
    double weight = 1;  // counts as this many independent points
};

/** A point on the drawn outline of the person or of a label. */
struct OutlineTerm {
    CarriedPoint point;
    const MaskDistance* outline = nullptr;
    double sigmaM = 1;
    double weight = 1;
};

/** Cost Σ weight · ρ(|r|²) over all terms, with ρ(s) = c² s/(s + c²), as a function of the frame's root and pose. Blocks: root, those of
 * the pose. All terms are compressed to columns + 1 residuals: with H = Σ ρ' JᵀJ = RᵀR, g = Σ ρ' Jᵀr and the cost C, the residuals are
 *  (R⁻ᵀg, √(C − |R⁻ᵀg|²)) and their Jacobian (R, 0). Cost and gradient are exact, and H is that of reweighted least squares. A call
 *  without Jacobian puts the whole cost into the last residual. */
class PictureCost final : public ceres::CostFunction {
public:
    /** Keeps references; `chain` must have no shape. `held`: as KeypointChain::evaluate() takes it. */
    PictureCost(const KeypointChain& chain, const Camerad& camera, const Mat3d& rootReference, const ContrastImage* contrast,
                std::vector<ContrastTerm> points, std::vector<OutlineTerm> outline, std::span<const Mat3d> held = {});
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    const KeypointChain& chain_;
    Camerad camera_;
    Mat3d rootReference_;
    const ContrastImage* contrast_;
    std::vector<ContrastTerm> points_;
    std::vector<OutlineTerm> outline_;
    std::span<const Mat3d> held_;
};

}  // namespace dpl
