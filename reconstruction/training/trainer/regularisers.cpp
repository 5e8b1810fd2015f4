// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/regularisers.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr float kEdgeSlack = 0.5f;

}  // namespace

void addSplatRegularisers(const TrainableSplats& splats, std::span<const float> referenceSizeM, std::span<const uint8_t> active,
                          const RegulariserWeights& w, size_t begin, size_t end, std::span<float> rowGradients) {
    const float n = 1.0f / float(std::max(1u, splats.count()));
    for (size_t i = begin; i < end; ++i) {
        if (!active[i]) continue;
        float* row = rowGradients.data() + i * splats.stride;
        const float h = referenceSizeM[splats.triangle[i]];
        const float floor = splats.sizeFloorM[splats.triangle[i]];
        const Vec2f s = splats.scaleM[i];
        float slope[2];  // ∂(ln s)/∂(log scale), below 1 because of the size floor
        for (int k = 0; k < 2; ++k) {
            slope[k] = std::max(0.0f, s[k] * s[k] - floor * floor) / (s[k] * s[k]);
            if (s[k] > kMaxSizeRatio * h) row[kRowLogScale1 + uint32_t(k)] += w.scaleHinge * n * s[k] / h * slope[k];
        }
        const float logRatio = std::log(s.x / s.y);
        if (std::abs(logRatio) > kLogAnisotropy) {
            const float g = w.anisotropy * n * (logRatio > 0 ? 1.0f : -1.0f);
            row[kRowLogScale1] += g * slope[0];
            row[kRowLogScale2] -= g * slope[1];
        }
    }
}

double splatRegulariserValue(const TrainableSplats& splats, std::span<const float> referenceSizeM, std::span<const uint8_t> active,
                             const RegulariserWeights& w) {
    double sum = 0;
    for (size_t i = 0; i < splats.count(); ++i) {
        if (!active[i]) continue;
        const double h = referenceSizeM[splats.triangle[i]];
        for (int k = 0; k < 2; ++k) sum += w.scaleHinge * std::max(0.0, splats.scaleM[i][k] / h - double(kMaxSizeRatio));
        sum += w.anisotropy * std::max(0.0, std::abs(std::log(double(splats.scaleM[i].x) / splats.scaleM[i].y)) - double(kLogAnisotropy));
    }
    return sum / std::max(1u, splats.count());
}

MeshRegulariser::MeshRegulariser(std::span<const Vec3f> positions, std::span<const Triangle> triangles)
    : rest_(positions.begin(), positions.end()) {
    for (const Triangle& t : triangles)
        for (int c = 0; c < 3; ++c) edges_.emplace_back(std::min(t[c], t[(c + 1) % 3]), std::max(t[c], t[(c + 1) % 3]));
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
    inverseValence_.assign(positions.size(), 0.0f);
    double sum = 0;
    for (const auto& [a, b] : edges_) {
        length_.push_back(std::max(1e-6f, glm::length(rest_[a] - rest_[b])));
        sum += length_.back();
        inverseValence_[a] += 1, inverseValence_[b] += 1;
    }
    for (float& v : inverseValence_) v = v > 0 ? 1 / v : 0;
    if (!edges_.empty()) meanEdge_ = float(sum / double(edges_.size()));
}

double MeshRegulariser::run(std::span<const Vec3f> moved, const RegulariserWeights& w, float scale, std::span<Vec3f> gradient) const {
    double value = 0;
    const float perEdge = w.edgeRatio / float(std::max<size_t>(1, edges_.size()));
    for (size_t e = 0; e < edges_.size(); ++e) {
        const auto [a, b] = edges_[e];
        const Vec3f d = moved[a] - moved[b];
        const float length = glm::length(d), error = length / length_[e] - 1, over = std::abs(error) - kEdgeSlack;
        if (!(over > 0)) continue;
        value += double(perEdge) * over * over;
        if (gradient.empty() || !(length > 0)) continue;
        const Vec3f g = scale * 2 * perEdge * over * (error > 0 ? 1.0f : -1.0f) / (length_[e] * length) * d;
        gradient[a] += g, gradient[b] -= g;
    }
    const float perVertex = w.laplacian / (float(std::max<size_t>(1, rest_.size())) * meanEdge_ * meanEdge_);
    std::vector<Vec3f> laplacian(rest_.size(), Vec3f(0));
    for (const auto& [a, b] : edges_) {
        const Vec3f d = (moved[a] - rest_[a]) - (moved[b] - rest_[b]);
        laplacian[a] += d * inverseValence_[a], laplacian[b] -= d * inverseValence_[b];
    }
    for (const Vec3f& l : laplacian) value += double(perVertex) * glm::dot(l, l);
    if (!gradient.empty())
        for (const auto& [a, b] : edges_) {
            const Vec3f g = scale * 2 * perVertex * (laplacian[a] * inverseValence_[a] - laplacian[b] * inverseValence_[b]);
            gradient[a] += g, gradient[b] -= g;
        }
    return value;
}

}  // namespace dpl
