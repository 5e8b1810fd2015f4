// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/light/light_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "reconstruction/training/light/priors.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/format/light.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr int kRounds = 8, kLeastMoving = 12;  // moving frames
constexpr size_t kLeastVertices = 200;         // seen both still and moving
constexpr double kRidge = 1e-3;                // share of the mean curvature: pulls what no normal tells towards no light
constexpr auto kTerms = int(kIrradianceCoefficients);
using Terms = Eigen::Matrix<double, kTerms, 1>;

Terms basisOf(const Vec3f& normal) {
    double basis[kMaxShCoefficients];
    shBasis(Vec3d(normal), 2, basis);
    return Terms(basis + 1);
}

LightData lightOf(const Terms& x) {
    LightData light;
    for (int i = 0; i < kTerms; ++i) light.irradiance[size_t(i)] = std::clamp(float(x[i]), -kMostIrradiance, kMostIrradiance);
    return light;
}

/** Sums of a vertex. */
struct VertexSums {
    double weight = 0, residual = 0;
    Terms slope = Terms::Zero();
};

/** The sightings under a light: what is left of each logarithm when the mean of its vertex is taken away. */
class Residuals {
public:
    Residuals(std::span<const LightSighting> sightings, size_t vertexCount)
        : sightings_(sightings), robust_(sightings.size(), 1.0), left_(sightings.size()), vertices_(vertexCount) {}

    void compute(const Terms& x) {
        const LightData light = lightOf(x);
        std::fill(vertices_.begin(), vertices_.end(), VertexSums());
        for (size_t i = 0; i < left_.size(); ++i) {
            const LightSighting& s = sightings_[i];
            left_[i] = double(s.logBrightness) - std::log(irradianceOn(light, Vec3d(s.normal)));
            vertices_[s.vertex].weight += weight(i), vertices_[s.vertex].residual += weight(i) * left_[i];
        }
        for (size_t i = 0; i < left_.size(); ++i) {
            const VertexSums& v = vertices_[sightings_[i].vertex];
            left_[i] -= v.residual / v.weight;
        }
    }

    /** Huber's weights for what is left. */
    void doubt() {
        for (size_t i = 0; i < left_.size(); ++i) robust_[i] = std::min(1.0, priors::kLightOutlier / std::max(std::abs(left_[i]), 1e-12));
    }

    /** A Gauss–Newton step from x; the albedo of each vertex is eliminated. */
    Terms step(const Terms& x) {
        const auto slopeOf = [&](const LightSighting& s) -> Terms {
            const Terms basis = basisOf(s.normal);
            const double e = 1 + basis.dot(x);
            return e > kMinIrradiance && e < kMaxIrradiance ? Terms(basis / e) : Terms(Terms::Zero());
        };
        for (size_t i = 0; i < left_.size(); ++i) vertices_[sightings_[i].vertex].slope += weight(i) * slopeOf(sightings_[i]);
        Eigen::Matrix<double, kTerms, kTerms> h = Eigen::Matrix<double, kTerms, kTerms>::Zero();
        Terms g = Terms::Zero();
        for (size_t i = 0; i < left_.size(); ++i) {
            const VertexSums& v = vertices_[sightings_[i].vertex];
            const Terms slope = slopeOf(sightings_[i]) - v.slope / v.weight;
            h += weight(i) * slope * slope.transpose(), g += weight(i) * left_[i] * slope;
        }
        const double ridge = kRidge * h.trace() / kTerms + 1e-12;
        h.diagonal().array() += ridge;
        return h.ldlt().solve(g - ridge * x);
    }

    double strayOfMoving() const {
        double squares = 0, weights = 0;
        for (size_t i = 0; i < left_.size(); ++i)
            if (sightings_[i].moving) squares += weight(i) * left_[i] * left_[i], weights += weight(i);
        return weights > 0 ? std::sqrt(squares / weights) : 0;
    }

private:
    double weight(size_t i) const { return double(sightings_[i].weight) * robust_[i]; }

    std::span<const LightSighting> sightings_;
    std::vector<double> robust_, left_;
    std::vector<VertexSums> vertices_;
};

size_t seenStillAndMoving(std::span<const LightSighting> sightings, size_t vertexCount) {
    std::vector<uint8_t> how(vertexCount, 0);
    for (const LightSighting& s : sightings) how[s.vertex] |= s.moving ? 1 : 2;
    return size_t(std::count(how.begin(), how.end(), 3));
}

}  // namespace

LightFit fitLight(std::span<const LightSighting> sightings, size_t vertexCount) {
    LightFit fit;
    if (seenStillAndMoving(sightings, vertexCount) < kLeastVertices) return fit;
    Residuals residuals(sightings, vertexCount);
    Terms x = Terms::Zero();
    residuals.compute(x);
    residuals.doubt();
    for (int round = 0; round < kRounds; ++round) {
        residuals.compute(x);
        x += residuals.step(x);
        residuals.compute(x);
        residuals.doubt();
    }
    residuals.compute(Terms::Zero());
    fit.strayBefore = residuals.strayOfMoving();
    residuals.compute(x);
    fit.strayAfter = residuals.strayOfMoving();
    fit.light = lightOf(x);
    return fit;
}

Result<LightFit> findLight(std::span<const JointData> joints, const MeshData& mesh, std::span<const TrainFrame> frames, Jobs& jobs) {
    const auto moving = std::ranges::count(frames, FrameKind::Dynamic, &TrainFrame::kind);
    if (moving < kLeastMoving) return LightFit{};
    DPL_TRY(const std::vector<LightSighting> sightings, lightSightings(joints, mesh, frames, jobs));
    return fitLight(sightings, mesh.restPositions.size());
}

}  // namespace dpl
