// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/body/landmark_offsets.h"

#include "reconstruction/priors.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr int kSteps = 12;
constexpr size_t kMinViews = 3;
constexpr double kLooseFactor = 5;  // the first steps widen the loss, because an offset of 3 cm looks like an outlier

}  // namespace

std::vector<Vec3d> estimateLandmarkOffsets(const KeypointChain& chain, std::span<const LandmarkView> views, double outlierSigmas) {
    std::vector<Vec3d> offsets(chain.keypointCount(), Vec3d(0));
    for (size_t k = 0; k < offsets.size(); ++k) {
        if (!chain.hasKeypoint(k)) continue;
        const uint32_t joint = chain.carrier(k);
        Vec3d& offset = offsets[k];
        for (int step = 0; step < kSteps; ++step) {
            const double c = outlierSigmas * (step < kSteps / 2 ? kLooseFactor : 1), c2 = c * c;
            const double pull = 1 / (priors::kLandmarkOffsetM * priors::kLandmarkOffsetM);
            Mat3d normal(pull);
            Vec3d right = -pull * offset;
            size_t seen = 0;
            for (const LandmarkView& view : views) {
                if (k >= view.keypoints.size() || !(view.keypoints[k].confidence > 0)) continue;
                const Mat3d viewFromCarrier = view.camera.viewFromWorldRotation * view.posed.rotations[joint];
                const Vec3d at = view.camera.toView(view.posed.points[k]) + viewFromCarrier * offset;
                if (!(at.z > kNearM)) continue;
                ++seen;
                const double perSigma = view.keypoints[k].confidence / view.sigmaPx;
                const Vec2d r = perSigma * (view.camera.pixelOf(at) - view.keypoints[k].px);
                const double weight = c2 / (glm::dot(r, r) + c2), w = weight * weight;
                const Vec3d rows[2] = {perSigma * view.camera.fx / at.z * Vec3d(1, 0, -at.x / at.z) * viewFromCarrier,
                                       perSigma * view.camera.fy / at.z * Vec3d(0, 1, -at.y / at.z) * viewFromCarrier};
                for (int a = 0; a < 2; ++a) normal += w * glm::outerProduct(rows[a], rows[a]), right -= w * r[a] * rows[a];
            }
            if (seen < kMinViews) {
                offset = Vec3d(0);
                break;
            }
            offset += glm::inverse(normal) * right;
        }
    }
    return offsets;
}

}  // namespace dpl
