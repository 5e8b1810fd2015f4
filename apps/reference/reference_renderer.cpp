// SPDX-License-Identifier: Apache-2.0
// Projection, spherical harmonics and blending in double precision. Blends one splat after the other in depth order over the whole image,
// without tiles or lists.
#include "apps/reference/reference_renderer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace dpl {
namespace {

constexpr double kMaxAlphaValue = 0.99, kNear = 0.05, kFadeEnd = 0.15, kGate = 0.1, kMargin = 0.3, kFloor = 0.005;

double smoothStep(double edge0, double edge1, double x) {
    const double t = std::clamp((x - edge0) / (edge1 - edge0), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/** Real spherical harmonics with constants computed from their definition, not literals; Condon-Shortley signs as in 3DGS files. */
std::vector<double> sphericalHarmonics(const glm::dvec3& d, uint32_t degree) {
    const double pi = std::numbers::pi, x = d.x, y = d.y, z = d.z;
    std::vector<double> b = {std::sqrt(1 / (4 * pi))};
    if (degree >= 1) {
        const double c = std::sqrt(3 / (4 * pi));
        b.insert(b.end(), {-c * y, c * z, -c * x});
    }
    if (degree >= 2) {
        const double c = std::sqrt(15 / (4 * pi));
        b.insert(b.end(),
                 {c * x * y, -c * y * z, std::sqrt(5 / (16 * pi)) * (2 * z * z - x * x - y * y), -c * x * z, c / 2 * (x * x - y * y)});
    }
    if (degree >= 3) {
        const double c3 = std::sqrt(35 / (32 * pi)), c2 = std::sqrt(105 / (4 * pi)), c1 = std::sqrt(21 / (32 * pi)),
                     c0 = std::sqrt(7 / (16 * pi));
        b.insert(b.end(), {-c3 * y * (3 * x * x - y * y), c2 * x * y * z, -c1 * y * (4 * z * z - x * x - y * y),
                           c0 * z * (2 * z * z - 3 * x * x - 3 * y * y), -c1 * x * (4 * z * z - x * x - y * y),
                           c2 / 2 * z * (x * x - y * y), -c3 * x * (x * x - 3 * y * y)});
    }
    return b;
}

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

ReferenceFootprint projectReference(const ReferenceGaussian& splat, const ReferenceCamera& camera, const ReferenceOptions& options) {
    ReferenceFootprint f;
    if (!splat.valid || !finite(splat.centre)) return f;
    const glm::dvec3 view = camera.rotation * splat.centre + camera.translation;
    f.depthM = view.z;
    if (!(view.z > kNear)) return f;
    f.centrePx = {camera.fx * view.x / view.z + camera.cx, camera.fy * view.y / view.z + camera.cy};

    const double marginX = kMargin * camera.widthPx / (2 * camera.fx), marginY = kMargin * camera.heightPx / (2 * camera.fy);
    const double slopeX = std::clamp(view.x / view.z, -camera.cx / camera.fx - marginX, (camera.widthPx - camera.cx) / camera.fx + marginX);
    const double slopeY =
        std::clamp(view.y / view.z, -camera.cy / camera.fy - marginY, (camera.heightPx - camera.cy) / camera.fy + marginY);
    glm::dvec2 b[3];  // columns of J·W·A
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 a = camera.rotation * splat.axes[k];
        b[k] = {camera.fx / view.z * (a.x - slopeX * a.z), camera.fy / view.z * (a.y - slopeY * a.z)};
    }
    glm::dmat2 plain(0.0);
    for (const glm::dvec2& column : b) plain += glm::outerProduct(column, column);
    // det(B·Bᵀ) = Σ minors² (Cauchy-Binet) avoids the cancellation in a·c − b².
    const auto minor = [&](int i, int j) { return b[i].x * b[j].y - b[j].x * b[i].y; };
    const double plainDet = minor(0, 1) * minor(0, 1) + minor(0, 2) * minor(0, 2) + minor(1, 2) * minor(1, 2);
    const double kappa = options.kappaPx2, det = plainDet + kappa * (plain[0][0] + plain[1][1]) + kappa * kappa;
    if (!(det > 0) || !std::isfinite(det)) return f;
    f.covariance = plain + glm::dmat2(kappa);
    f.conic = glm::dmat2(f.covariance[1][1], -f.covariance[0][1], -f.covariance[1][0], f.covariance[0][0]) / det;
    if (options.compensated) f.compensation = std::max(kFloor, std::sqrt(plainDet / det));

    const glm::dvec3 eye = -(glm::transpose(camera.rotation) * camera.translation), toEye = eye - splat.centre;
    f.nearFade = smoothStep(kNear, kFadeEnd, view.z);
    if (splat.singleFace) f.gate = smoothStep(0, kGate, glm::dot(splat.normal, toEye) / glm::length(toEye));
    f.opacity = splat.opacity * f.compensation * f.gate * f.nearFade;
    if (!std::isfinite(f.opacity)) return f;

    const glm::dvec3 direction = glm::transpose(splat.worldFromRest) * (-toEye / glm::length(toEye));
    const std::vector<double> basis = sphericalHarmonics(direction, splat.shDegree);
    f.colour = glm::dvec3(0.5);
    for (size_t k = 0; k < basis.size(); ++k)
        for (int c = 0; c < 3; ++c) f.colour[c] += basis[k] * splat.sh[k * 3 + size_t(c)];
    f.colour *= splat.light;
    if (options.clampColour) f.colour = glm::clamp(f.colour, 0.0, 1.0);
    f.cloth = splat.cloth;
    f.visible = true;
    return f;
}

double referenceAlpha(const ReferenceFootprint& footprint, const glm::dvec2& pointPx) {
    const glm::dvec2 d = pointPx - footprint.centrePx;
    return std::min(kMaxAlphaValue, footprint.opacity * std::exp(-0.5 * glm::dot(d, footprint.conic * d)));
}

namespace {

/** Blends `order` front to back at one place of every pixel and adds `share` of the result to the image; alpha collects 1 − T. */
void addSample(const std::vector<ReferenceFootprint>& footprints, const std::vector<size_t>& order, const glm::dvec2& placePx, double share,
               const ReferenceOptions& options, ReferenceImage& image) {
    std::vector<double> transmittance(image.alpha.size(), 1.0);
    for (const size_t index : order) {
        const ReferenceFootprint& f = footprints[index];
        const double faintest = std::max(options.minAlpha, 1e-20);
        if (!(f.opacity >= faintest)) continue;
        const double q = 2 * std::log(f.opacity / faintest);
        const double rx = std::sqrt(q * f.covariance[0][0]), ry = std::sqrt(q * f.covariance[1][1]);
        const auto first = [](double x) { return uint32_t(std::max(0.0, std::floor(x) - 1)); };
        const auto last = [](double x, uint32_t size) { return uint32_t(std::clamp(std::ceil(x) + 1, 0.0, double(size))); };
        if (!(f.centrePx.x - rx < image.widthPx && f.centrePx.y - ry < image.heightPx)) continue;
        for (uint32_t y = first(f.centrePx.y - ry); y < last(f.centrePx.y + ry, image.heightPx); ++y)
            for (uint32_t x = first(f.centrePx.x - rx); x < last(f.centrePx.x + rx, image.widthPx); ++x) {
                const size_t pixel = size_t(y) * image.widthPx + x;
                double& t = transmittance[pixel];
                const double alpha = referenceAlpha(f, {x + placePx.x, y + placePx.y});
                if (t <= options.minTransmittance || alpha < faintest) continue;
                if (!options.sceneDepthM.empty() && options.sceneDepthM[pixel] > 0 && f.depthM > double(options.sceneDepthM[pixel]))
                    continue;
                const double weight = alpha * t * share;
                for (int c = 0; c < 3; ++c) image.rgb[pixel * 3 + size_t(c)] += weight * f.colour[c];
                image.cloth[pixel] += f.cloth ? weight : 0;
                image.depthM[pixel] += weight * f.depthM;
                t -= alpha * t;
            }
    }
    for (size_t i = 0; i < transmittance.size(); ++i) image.alpha[i] += share * (1 - transmittance[i]);
}

}  // namespace

ReferenceImage renderReference(const std::vector<ReferenceGaussian>& splats, const ReferenceCamera& camera,
                               const ReferenceOptions& options) {
    ReferenceImage image{camera.widthPx, camera.heightPx, {}, {}, {}, {}};
    const size_t pixels = size_t(image.widthPx) * image.heightPx;
    image.rgb.assign(pixels * 3, 0), image.alpha.assign(pixels, 0), image.cloth.assign(pixels, 0), image.depthM.assign(pixels, 0);

    // Each sample covers a quarter of the pixel, so its low-pass filter is scaled to that size.
    ReferenceOptions ofSample = options;
    if (options.fourSamples) ofSample.kappaPx2 = options.kappaPx2 / 4;
    std::vector<ReferenceFootprint> footprints;
    for (const ReferenceGaussian& splat : splats) {
        footprints.push_back(projectReference(splat, camera, ofSample));
        if (!footprints.back().visible) footprints.pop_back();
    }
    std::vector<size_t> order(footprints.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return footprints[a].depthM < footprints[b].depthM; });

    if (options.fourSamples) {
        // The standard sample locations of Vulkan, Metal and Direct3D, in sixteenths of a pixel.
        for (const glm::dvec2 place : {glm::dvec2(6, 2), glm::dvec2(14, 6), glm::dvec2(2, 10), glm::dvec2(10, 14)})
            addSample(footprints, order, place / 16.0, 0.25, options, image);
    } else {
        addSample(footprints, order, {0.5, 0.5}, 1, options, image);
    }
    for (size_t i = 0; i < pixels; ++i)
        if (image.alpha[i] > 0) image.depthM[i] /= image.alpha[i];
    return image;
}

ReferenceImage renderReference(const ReferenceScene& scene, const ReferenceCamera& camera, const ReferenceOptions& options) {
    std::vector<ReferenceGaussian> splats;
    for (const ReferenceBoundSplat& splat : scene.splats) splats.push_back(referenceGaussian(scene, splat));
    return renderReference(splats, camera, options);
}

bool referenceFourSamples(const AvatarData& avatar, const Pose& pose, const ReferenceCamera& camera) {
    const glm::dvec3 root = glm::dvec3(avatar.joints[0].restPosition) + glm::dvec3(pose.rootTranslation);
    const double distanceM = (camera.rotation * root + camera.translation).z;
    return avatar.trainedPixelM > 0 && distanceM / std::max(camera.fx, camera.fy) > 1.25 * avatar.trainedPixelM;
}

ReferenceImage renderReference(const AvatarData& avatar, const Pose& pose, const ReferenceCamera& camera,
                               const std::vector<float>& sceneDepthM) {
    return renderReference(sceneOf(avatar, pose), camera,
                           {.kappaPx2 = avatar.kappaPx2,
                            .compensated = avatar.compensated,
                            .sceneDepthM = sceneDepthM,
                            .fourSamples = referenceFourSamples(avatar, pose, camera)});
}

ReferenceImage renderReference(const StaticSplatData& splats, const ReferenceCamera& camera, const ReferenceOptions& options) {
    std::vector<ReferenceGaussian> gaussians;
    for (uint32_t i = 0; i < splats.count(); ++i) gaussians.push_back(referenceGaussian(splats, i));
    return renderReference(gaussians, camera, options);
}

}  // namespace dpl
