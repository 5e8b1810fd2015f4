// SPDX-License-Identifier: Apache-2.0
#include "apps/reference/reference_detail.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dpl {
namespace {

constexpr double kNearestM = 0.25, kFade = 0.5, kThrough = 0.02, kMeasuredAt = 0.25;
constexpr uint32_t kGroup = 128;

/** Weight of the splat at place `at` of its group. Its rank is the place with its seven bits reversed. The weight is 1 up to the kept share
 * of the ranks and falls linearly to 0 behind it. */
double weightOf(double share, uint32_t at) {
    if (share >= 1) return 1;
    double place = 0.5 / kGroup, half = 0.5;
    for (; at > 0; at /= 2, half /= 2) place += at % 2 ? half : 0;
    return std::clamp((share * (1 + kFade) - place) / (share * kFade), 0.0, 1.0);
}

/** How many splats one splat counts as: 3 on the face, 2 on a hand, 1 elsewhere, mixed by the weights of the joints. */
double favourOf(const AvatarData& avatar, uint32_t triangle) {
    double mean = 0;
    for (int corner = 0; corner < 3; ++corner)
        for (int k = 0; k < 4; ++k) {
            const uint32_t vertex = avatar.mesh.triangles[triangle][corner];
            const std::string& bone = avatar.joints[avatar.mesh.jointIndices[vertex][k]].humanoidBone;
            const double favour = bone == "head" || bone == "jaw" || bone == "leftEye" || bone == "rightEye"   ? 3
                                  : bone.starts_with("leftIndex") || bone == "leftHand" || bone == "rightHand" ? 2
                                                                                                               : 1;
            mean += favour * avatar.mesh.jointWeights[vertex][k] / 255.0 / 3;
        }
    return mean;
}

struct Kept {
    double share = 1, growth = 1;
};

/** The kept share and growth of a group that should keep the share `wanted`. cover: area of all its splats divided by the area of the
 *  group. coverThere: the same for the splats that are left at the share kMeasuredAt. */
Kept keptOf(double wanted, double cover, double coverThere) {
    Kept kept;
    kept.share = std::clamp(wanted, 1.0 / kGroup, 1.0);
    const double gain = std::clamp(std::log(coverThere / cover) / std::log(kMeasuredAt), 0.0, 1.0),
                 enough = std::clamp(-std::log(std::exp(-cover) + kThrough) / cover, 0.0, 1.0);
    if (kept.share < 1) kept.growth = std::sqrt(std::max(1.0, enough / std::pow(kept.share, gain)));
    return kept;
}

/** Sum of the products of each two eigenvalues of a symmetric matrix. For a covariance that is the sum of the squared areas (without π)
 *  of the ellipsoid's three silhouettes along its axes. */
double shadows(const glm::dmat3& m) {
    const glm::dmat3 square = m * m;
    const double trace = m[0][0] + m[1][1] + m[2][2];
    return 0.5 * (trace * trace - square[0][0] - square[1][1] - square[2][2]);
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
                        low = glm::min(low, glm::dvec3(avatar.mesh.restPositions[v])),
                        high = glm::max(high, glm::dvec3(avatar.mesh.restPositions[v]));
            if (!(low.x <= high.x)) continue;
            const glm::dvec3 world(joints[j] * glm::dvec4(0.5 * (low + high), 1));
            nearest = std::min(nearest, (camera.rotation * world + camera.translation).z - 0.5 * glm::length(high - low));
        }
        finest = std::min(finest, std::max(nearest, kNearestM) / std::max(camera.fx, camera.fy));
    }
    return finest;
}

void reduceReference(ReferenceScene& scene, const AvatarData& avatar, const CodedSplats& coded, double perM2) {
    std::vector<double> areaOf(avatar.mesh.triangles.size());  // area per splat of each triangle, m²
    double surface = 0;
    for (size_t t = 0; t < areaOf.size(); ++t) {
        const glm::uvec3 c = avatar.mesh.triangles[t];
        const glm::dvec3 a(avatar.mesh.restPositions[c.x]), b(avatar.mesh.restPositions[c.y]), d(avatar.mesh.restPositions[c.z]);
        const uint32_t count = avatar.splats.triangleStart[t + 1] - avatar.splats.triangleStart[t];
        const double area = 0.5 * glm::length(glm::cross(b - a, d - a));
        areaOf[t] = count ? area / count : 0;
        surface += count ? area : 0;
    }
    // Favours are divided by their mean, so the total number of splats does not change.
    double favoured = 0;
    const auto favourOfChunk = [&](uint32_t first, uint32_t n) {
        double sum = 0;
        for (uint32_t r = 0; r < n; ++r) sum += favourOf(avatar, scene.splats[first + r].triangle) / n;
        return sum;
    };
    for (const SplatChunk& chunk : coded.chunks)
        for (uint32_t first = chunk.firstSplat; first < chunk.firstSplat + chunk.splatCount; first += kGroup) {
            const uint32_t n = std::min(kGroup, chunk.firstSplat + chunk.splatCount - first);
            double area = 0;
            for (uint32_t r = 0; r < n; ++r) area += areaOf[scene.splats[first + r].triangle];
            favoured += area * favourOfChunk(first, n);
        }
    const double shShare = std::clamp((std::min(perM2 * surface / double(scene.splats.size()), 1.0) - 0.125) / 0.125, 0.0, 1.0);
    for (const SplatChunk& chunk : coded.chunks)
        for (uint32_t first = chunk.firstSplat; first < chunk.firstSplat + chunk.splatCount; first += kGroup) {
            const uint32_t n = std::min(kGroup, chunk.firstSplat + chunk.splatCount - first);
            double area = 0, covered = 0, coveredThere = 0;
            for (uint32_t r = 0; r < n; ++r) {
                const ReferenceBoundSplat& s = scene.splats[first + r];
                const double own = 2 * std::numbers::pi * s.opacity * s.scaleM.x * s.scaleM.y;
                area += areaOf[s.triangle], covered += own, coveredThere += weightOf(kMeasuredAt, r) * own;
            }
            const auto [share, growth] =
                keptOf(perM2 * area / n * favourOfChunk(first, n) * surface / favoured, covered / area, coveredThere / area);
            for (uint32_t r = 0; r < n; ++r) {
                ReferenceBoundSplat& s = scene.splats[first + r];
                s.opacity *= weightOf(share, r);
                s.scaleM *= growth;
                for (size_t k = 3; k < s.sh.size(); ++k) s.sh[k] *= shShare;
            }
        }
}

std::vector<ReferenceGaussian> reducedReference(const StaticSplatData& splats, const std::vector<uint32_t>& order,
                                                const std::vector<ReferenceCamera>& cameras, double perPixel) {
    std::vector<ReferenceGaussian> out;
    for (const uint32_t i : order) out.push_back(referenceGaussian(splats, i));
    for (size_t first = 0; first < out.size(); first += kGroup) {
        const size_t n = std::min<size_t>(kGroup, out.size() - first);
        glm::dvec3 low(INFINITY), high(-INFINITY), mean(0);
        double covered = 0, coveredThere = 0;
        glm::dmat3 spread(0);
        for (size_t r = 0; r < n; ++r)
            low = glm::min(low, out[first + r].centre), high = glm::max(high, out[first + r].centre),
            mean += out[first + r].centre / double(n);
        for (size_t r = 0; r < n; ++r) {
            const ReferenceGaussian& s = out[first + r];
            glm::dmat3 own(0);
            for (const glm::dvec3& axis : s.axes) own += glm::outerProduct(axis, axis);
            spread += (glm::outerProduct(s.centre - mean, s.centre - mean) + own) / double(n);
            const double covers = 2 * std::numbers::pi * s.opacity * std::sqrt(shadows(own));
            covered += covers, coveredThere += weightOf(kMeasuredAt, uint32_t(r)) * covers;
        }
        double pixel = INFINITY, smallest = INFINITY;
        for (const ReferenceCamera& camera : cameras) {
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 at(corner & 1 ? low.x : high.x, corner & 2 ? low.y : high.y, corner & 4 ? low.z : high.z);
                pixel = std::min(pixel, (camera.rotation * at + camera.translation).z / std::max(camera.fx, camera.fy));
            }
            smallest = std::min(smallest, kNearestM / std::max(camera.fx, camera.fy));
        }
        pixel = std::max(pixel, smallest);
        const double area = 12 * std::sqrt(shadows(spread));
        const auto [share, growth] = keptOf(perPixel * area / double(n) / (pixel * pixel), covered / area, coveredThere / area);
        for (size_t r = 0; r < n; ++r) {
            out[first + r].opacity *= weightOf(share, uint32_t(r));
            for (glm::dvec3& axis : out[first + r].axes) axis *= growth;
        }
    }
    return out;
}

}  // namespace dpl
