// SPDX-License-Identifier: Apache-2.0
// Shape residuals from silhouettes: the body's outline against the person mask of still train frames. A body that sticks out of the mask
// costs much. A body a few centimetres inside it costs little, because people wear clothes.
#pragma once

#include <memory>
#include <vector>

#include "reconstruction/subject/body/fit_costs.h"
#include "sdk/core/result.h"

namespace dpl {

/** Signed distance of every mask pixel to the mask's edge, negative inside. */
struct MaskDistance {
    uint32_t widthPx = 0, heightPx = 0;
    double maskPerCameraPx = 1;     // masks may be reduced: mask px = camera px × this
    std::vector<float> distancePx;  // mask pixels, row-major

    /** Bilinear distance at a camera pixel, in camera pixels, and its gradient. Outside the image the nearest edge value is used. */
    double sample(const Vec2d& cameraPx, Vec2d& gradient) const;
};
/** The mask is first reduced until its longer side is at most `maxSidePx`. NotFound when it shows no outline. */
Result<MaskDistance> maskDistance(const ImageGrey8& mask, uint32_t maxSidePx);

/** Vertices spread evenly over the skin, as keypoints for a KeypointChain. */
struct SkinSamples {
    BodyModel body;  // its keypoints are the samples
    std::vector<std::string> names;
    std::vector<uint32_t> joint;    // the joint with the sample's largest skin weight
    std::vector<Vec3d> restNormal;  // unit
};
SkinSamples sampleSkin(const BodyModel& body, size_t count);

/** Indices of the samples that lie on the outline of the posed body in one view. */
std::vector<size_t> outlineSamples(const SkinSamples& samples, const KeypointChain::Output& posed, const Camerad& metricCamera,
                                   const MaskDistance& mask);

/** One residual per outline sample. Blocks as ReprojectionCost with sway. `outline` holds indices of points of `skin`. The references must
 *  outlive the cost. */
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
