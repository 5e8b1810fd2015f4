#include "tests/reference/reference_detail.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dpl {
namespace {

constexpr double kNearestM = 0.25, kFade = 0.5, kThrough = 0.02, kMeasuredAt = 0.25;
constexpr uint32_t kHalfChunk = 128;

/** Of the splat at a place of its half-chunk. Its rank is the place with its seven bits in reverse; 1 up to the kept share of the ranks, then a straight line to 0 half as far again. */
double weightOf(double share, uint32_t at) {
    if (share >= 1) return 1;
    double place = 0.5 / kHalfChunk, half = 0.5;
    for (; at > 0; at /= 2, half /= 2) place += at % 2 ? half : 0;
    return std::clamp((share * (1 + kFade) - place) / (share * kFade), 0.0, 1.0);
}

}  // namespace

double referenceFinestPixelM(const AvatarData& avatar, const Pose& pose, const std::vector<ReferenceCamera>& cameras) {
    const std::vector<glm::dmat4> joints = referenceJointTransforms(avatar.joints, pose);
    double finest = INFINITY;
    for (const ReferenceCamera& camera : cameras) {
        double nearest = INFINITY;
        for (size_t j = 0; j < joints.size(); ++j) {
            glm::dvec3 low(INFINITY), high(-INFINITY);
            for (size_t v = 0; v < avatar.mesh.restPositions.size(); ++v)
                for (int k = 0; k < 4; ++k)
                    if (avatar.mesh.jointIndices[v][k] == j && avatar.mesh.jointWeights[v][k] > 0)
                        low = glm::min(low, glm::dvec3(avatar.mesh.restPositions[v])), high = glm::max(high, glm::dvec3(avatar.mesh.restPositions[v]));
            if (!(low.x <= high.x)) continue;
            const glm::dvec3 world(joints[j] * glm::dvec4(0.5 * (low + high), 1));
            nearest = std::min(nearest, (camera.rotation * world + camera.translation).z - 0.5 * glm::length(high - low));
        }
        finest = std::min(finest, std::max(nearest, kNearestM) / std::max(camera.fx, camera.fy));
    }
    return finest;
}

void reduceReference(ReferenceScene& scene, const AvatarData& avatar, const CodedSplats& coded, double perM2) {
    std::vector<double> areaOf(avatar.mesh.triangles.size());   // of a splat on a triangle
    double surface = 0;
    for (size_t t = 0; t < areaOf.size(); ++t) {
        const glm::uvec3 c = avatar.mesh.triangles[t];
        const glm::dvec3 a(avatar.mesh.restPositions[c.x]), b(avatar.mesh.restPositions[c.y]), d(avatar.mesh.restPositions[c.z]);
        const uint32_t count = avatar.splats.triangleStart[t + 1] - avatar.splats.triangleStart[t];
        const double area = 0.5 * glm::length(glm::cross(b - a, d - a));
        areaOf[t] = count ? area / count : 0;
        surface += count ? area : 0;
    }
    const double shShare = std::clamp((std::min(perM2 * surface / double(scene.splats.size()), 1.0) - 0.125) / 0.125, 0.0, 1.0);
    for (const SplatChunk& chunk : coded.chunks)
        for (uint32_t first = chunk.firstSplat; first < chunk.firstSplat + chunk.splatCount; first += kHalfChunk) {
            const uint32_t n = std::min(kHalfChunk, chunk.firstSplat + chunk.splatCount - first);
            double area = 0, covered = 0, coveredThere = 0;
            for (uint32_t r = 0; r < n; ++r) {
                const ReferenceBoundSplat& s = scene.splats[first + r];
                const double own = 2 * std::numbers::pi * s.opacity * s.scaleM.x * s.scaleM.y;
                area += areaOf[s.triangle], covered += own, coveredThere += weightOf(kMeasuredAt, r) * own;
            }
            const double share = std::clamp(perM2 * area / n, 1.0 / kHalfChunk, 1.0), gain = std::clamp(std::log(coveredThere / covered) / std::log(kMeasuredAt), 0.0, 1.0);
            const double cover = covered / area, enough = std::clamp(-std::log(std::exp(-cover) + kThrough) / cover, 0.0, 1.0);
            const double growth = share < 1 ? std::sqrt(std::max(1.0, enough / std::pow(share, gain))) : 1;
            for (uint32_t r = 0; r < n; ++r) {
                ReferenceBoundSplat& s = scene.splats[first + r];
                s.opacity *= weightOf(share, r);
                s.scaleM *= growth;
                for (size_t k = 3; k < s.sh.size(); ++k) s.sh[k] *= shShare;
            }
        }
}

}  // namespace dpl
