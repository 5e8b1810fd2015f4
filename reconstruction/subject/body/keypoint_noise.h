// SPDX-License-Identifier: Apache-2.0
// Estimates the noise of a keypoint detector from the reprojection residuals of a fit.
#pragma once

#include <optional>
#include <span>

#include "sdk/math/types.h"

namespace dpl {

struct KeypointNoise {
    double sigma = 0;         // standard deviation of one coordinate at full confidence, in the unit of the residuals
    double outlierShare = 0;  // of the residuals: longer than outlierSigmas × sigma
};

/** `residuals`: one per keypoint, multiplied by its confidence. `freedom`: effective number of parameters that were fitted to them; it
 *  makes residuals smaller than the noise. σ = 1.4826 × the median of |coordinate| × √(n / (n − freedom)) over n coordinates. Outliers
 * raise it by their share and not by their size: 5 % of them by 6 %, 20 % by 32 %. Returns nullopt for fewer than 100 finite residuals, for
 *  freedom above n / 2, or when more than half of the coordinates are zero. */
std::optional<KeypointNoise> estimateKeypointNoise(std::span<const Vec2d> residuals, double freedom, double outlierSigmas);

}  // namespace dpl
