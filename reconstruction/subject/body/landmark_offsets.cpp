// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/landmark_offsets.h"

#include <array>

#include "reconstruction/subject/body/priors.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

/** Where our networks mark a keypoint: millimetres from the rig's point. */
struct FoundLandmark {
    std::string_view keypoint;                // without its side
    double outMm = 0, upMm = 0, frontMm = 0;  // out: away from the middle of the body
};
// From keypoints triangulated over the still training pictures of the development set, where its scans agree in sign, to 5 mm
// (docs/reference/observations.md). landmarks.cpp corrects what is proportional to a limb: hips, knees and shoulders up or down.
constexpr std::array<FoundLandmark, 12> kFoundLandmarks = {{{"nose", 0, 10, -10},
                                                            {"eye", 0, 0, -10},
                                                            {"ear", -25, 0, 40},
                                                            {"neck", 0, 0, 40},
                                                            {"elbow", 0, 0, 20},
                                                            {"wrist", -10, -15, 10},
                                                            {"knuckle", -15, 0, -20},
                                                            {"pelvis", 0, 0, 15},
                                                            {"hip", 0, 0, 25},
                                                            {"ankle", -20, 10, 0},
                                                            {"toe", -20, 0, -10},
                                                            {"head_top", 0, 15, 55}}};

constexpr int kSteps = 12;
constexpr size_t kMinViews = 3;
constexpr double kLooseFactor = 5;  // the first steps widen the loss, because an offset of 3 cm looks like an outlier

}  // namespace

Vec3d foundLandmarkOffset(std::string_view keypoint) {
    const bool left = keypoint.ends_with("_l"), right = keypoint.ends_with("_r");
    const std::string_view part = left || right ? keypoint.substr(0, keypoint.size() - 2) : keypoint;
    for (const FoundLandmark& found : kFoundLandmarks)
        if (found.keypoint == part) return 0.001 * Vec3d(right ? -found.outMm : found.outMm, found.upMm, found.frontMm);
    return Vec3d(0);
}

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
