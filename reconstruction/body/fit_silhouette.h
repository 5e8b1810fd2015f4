// SPDX-License-Identifier: Apache-2.0
// Silhouette evidence for shape: the body's outline against the person mask of still train frames, loosely, because people wear clothes.
// A body that sticks out of the mask is wrong; a body a few centimetres inside it may be clothed.
#pragma once

#include <memory>
#include <vector>

#include "reconstruction/body/fit_costs.h"
#include "sdk/core/result.h"

namespace dpl {

/** Signed distance to the mask's edge, pixels of the mask, negative inside; smooth enough to differentiate. */
struct MaskDistance {
    uint32_t widthPx = 0, heightPx = 0;
    double maskPerCameraPx = 1;  // masks may be reduced: mask px = camera px × this
    std::vector<float> distancePx;

    /** Bilinear value and gradient at a camera pixel, both in camera pixels; beyond the image the nearest edge value. */
    double sample(const Vec2d& cameraPx, Vec2d& gradient) const;
};
/** Reduced so that its longer side is at most `maxSidePx`. */
Result<MaskDistance> maskDistance(const ImageGrey8& mask, uint32_t maxSidePx);

/** Vertices of the body as points of a KeypointChain, spread evenly over the skin, with their rest normals. */
struct SkinSamples {
    BodyModel body;  // the body with one keypoint a sample
    std::vector<std::string> names;
    std::vector<uint32_t> joint;  // the joint that holds most of the sample
    std::vector<Vec3d> restNormal;
};
SkinSamples sampleSkin(const BodyModel& body, size_t count);

/** Which samples form the outline in one view, found from the present fit. */
std::vector<size_t> outlineSamples(const SkinSamples& samples, const KeypointChain::Output& posed, const Camerad& metricCamera,
                                   const MaskDistance& mask);

/** One residual an outline sample. Blocks as ReprojectionCost with sway. `outline` index the chain's points. */
class SilhouetteCost final : public ceres::CostFunction {
public:
    SilhouetteCost(const FitContext& context, const KeypointChain& skin, const Camerad& camera, const Mat3d& rootReference,
                   const MaskDistance& mask, std::vector<size_t> outline);
    bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

private:
    const FitContext& context_;
    const KeypointChain& skin_;
    Camerad camera_;
    Mat3d rootReference_;
    const MaskDistance& mask_;
    std::vector<size_t> outline_;
};

}  // namespace dpl
