// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/align_cameras.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr int kRounds = 3;        // each leaves out what fits badly in the one before
constexpr double kFarOff = 6;     // times the median distance: left out
constexpr double kSpread = 1e-9;  // root mean square distance of the eyes from their mean, relative to their size: one place

/** The rotation nearest to a sum of rotations (the chordal mean). */
Mat3d nearestRotation(const Mat3d& sum) {
    Eigen::Matrix3d m;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) m(r, c) = sum[c][r];
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double mirror = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Eigen::Matrix3d rotation = svd.matrixU() * Eigen::Vector3d(1, 1, mirror).asDiagonal() * svd.matrixV().transpose();
    Mat3d out;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) out[c][r] = rotation(r, c);
    return out;
}

/** Least squares over the chosen cameras; nullopt when their eyes lie at one place. */
std::optional<Similarity> alignChosen(std::span<const Camerad> from, std::span<const Camerad> to, const std::vector<bool>& chosen) {
    Mat3d sum(0.0);
    Vec3d meanFrom(0), meanTo(0);
    double count = 0;
    for (size_t i = 0; i < from.size(); ++i)
        if (chosen[i]) {
            sum += glm::transpose(to[i].viewFromWorldRotation) * from[i].viewFromWorldRotation;
            meanFrom += from[i].eye(), meanTo += to[i].eye(), ++count;
        }
    if (count < 2) return std::nullopt;
    meanFrom /= count, meanTo /= count;
    Similarity out;
    out.rotation = nearestRotation(sum);
    double along = 0, square = 0, size = 0;
    for (size_t i = 0; i < from.size(); ++i)
        if (chosen[i]) {
            const Vec3d a = out.rotation * (from[i].eye() - meanFrom), b = to[i].eye() - meanTo;
            along += glm::dot(a, b), square += glm::dot(a, a), size += glm::dot(from[i].eye(), from[i].eye());
        }
    if (!(square > kSpread * kSpread * size) || !(along > 0)) return std::nullopt;
    out.scale = along / square;
    out.translation = meanTo - out.scale * (out.rotation * meanFrom);
    return out;
}

}  // namespace

Camerad moved(const Camerad& camera, const Similarity& s) {
    // X = Rᵀ(X' − T)/s, put into the camera's equation and multiplied by s, which changes no pixel.
    Camerad out = camera;
    out.viewFromWorldRotation = camera.viewFromWorldRotation * glm::transpose(s.rotation);
    out.viewFromWorldTranslation = s.scale * camera.viewFromWorldTranslation - out.viewFromWorldRotation * s.translation;
    return out;
}

std::optional<Similarity> alignCameras(std::span<const Camerad> from, std::span<const Camerad> to) {
    if (from.size() != to.size()) return std::nullopt;
    std::vector<bool> chosen(from.size(), true);
    std::optional<Similarity> found;
    for (int round = 0; round < kRounds; ++round) {
        const auto next = alignChosen(from, to, chosen);
        if (!next) return found;
        found = next;
        std::vector<double> eyes, turns;
        for (size_t i = 0; i < from.size(); ++i) {
            const CameraError error = cameraError(moved(from[i], *found), to[i], {});
            eyes.push_back(error.eye), turns.push_back(error.rotationRad);
        }
        const double eyeLimit = kFarOff * percentile(eyes, 0.5), turnLimit = kFarOff * percentile(turns, 0.5);
        for (size_t i = 0; i < from.size(); ++i) chosen[i] = eyes[i] <= eyeLimit && turns[i] <= turnLimit;
    }
    return found;
}

CameraError cameraError(const Camerad& camera, const Camerad& truth, std::span<const Vec3d> points) {
    CameraError error;
    error.eye = glm::length(camera.eye() - truth.eye());
    // ‖R − R'‖² = 8 sin²(angle/2), exact for small angles, where the trace is not.
    double square = 0;
    for (int c = 0; c < 3; ++c) {
        const Vec3d off = camera.viewFromWorldRotation[c] - truth.viewFromWorldRotation[c];
        square += glm::dot(off, off);
    }
    error.rotationRad = 2 * std::asin(std::min(1.0, std::sqrt(square / 8)));
    std::vector<double> distances;
    for (const Vec3d& point : points) {
        const Vec3d a = camera.toView(point), b = truth.toView(point);
        if (a.z > 0 && b.z > 0) distances.push_back(glm::length(camera.pixelOf(a) - truth.pixelOf(b)));
    }
    error.px = distances.empty() ? -1 : percentile(distances, 0.5);
    return error;
}

}  // namespace dpl
