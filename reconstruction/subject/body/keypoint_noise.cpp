// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/keypoint_noise.h"

#include <cmath>
#include <vector>

#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr size_t kMinResiduals = 100;       // with these the standard error of σ is 8 %
constexpr double kSigmaPerMedian = 1.4826;  // 1 / Φ⁻¹(3/4), for a normal distribution

}  // namespace

std::optional<KeypointNoise> estimateKeypointNoise(std::span<const Vec2d> residuals, double freedom, double outlierSigmas) {
    std::vector<double> coordinates;
    std::vector<double> lengths;
    for (const Vec2d& r : residuals) {
        if (!std::isfinite(r.x) || !std::isfinite(r.y)) continue;
        coordinates.insert(coordinates.end(), {std::abs(r.x), std::abs(r.y)});
        lengths.push_back(glm::length(r));
    }
    const double count = double(coordinates.size());
    if (lengths.size() < kMinResiduals || !(freedom >= 0 && freedom <= count / 2)) return std::nullopt;
    KeypointNoise noise;
    noise.sigma = kSigmaPerMedian * percentile(coordinates, 0.5) * std::sqrt(count / (count - freedom));
    if (!(noise.sigma > 0)) return std::nullopt;
    size_t outliers = 0;
    for (const double length : lengths) outliers += length > outlierSigmas * noise.sigma;
    noise.outlierShare = double(outliers) / double(lengths.size());
    return noise;
}

}  // namespace dpl
