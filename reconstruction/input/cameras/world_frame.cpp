// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/world_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "reconstruction/input/cameras/rays.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr size_t kFewestFloorPoints = 60;
constexpr double kMaxTiltRad = 15 * std::numbers::pi / 180;
// Thickness of the slab in which the floor is sought, relative to the reach of the cameras: from what the cameras' mean up is wrong by to
// the roughness of a floor's points.
constexpr double kFirstSlab = 0.15, kLastSlab = 0.015, kSlabFactor = 0.6;
constexpr double kAnkleShare = 0.045;  // height of the ankle joint over the body height

/** Mean of the cameras' own up. */
std::optional<Vec3d> meanUp(std::span<const Camerad> cameras) {
    Vec3d up(0);
    for (const Camerad& camera : cameras) up -= glm::transpose(camera.viewFromWorldRotation) * Vec3d(0, 1, 0);
    const double length = glm::length(up);
    if (!(length > 0.1 * double(cameras.size())) || cameras.empty()) return std::nullopt;
    return up / length;
}

/** Root mean square distance of the eyes from their mean. */
double reachOf(std::span<const Camerad> cameras) {
    Vec3d mean(0);
    for (const Camerad& camera : cameras) mean += camera.eye() / double(cameras.size());
    double square = 0;
    for (const Camerad& camera : cameras) square += glm::dot(camera.eye() - mean, camera.eye() - mean) / double(cameras.size());
    return std::sqrt(square);
}

/** Plane through points by least squares; its normal is the direction of least spread, on the side of `up`. */
FloorPlane planeThrough(const std::vector<Vec3d>& points, const Vec3d& up) {
    FloorPlane plane;
    plane.points = points.size();
    for (const Vec3d& p : points) plane.point += p / double(points.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vec3d& p : points) {
        const Eigen::Vector3d d(p.x - plane.point.x, p.y - plane.point.y, p.z - plane.point.z);
        spread += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    plane.normal = {n.x(), n.y(), n.z()};
    if (glm::dot(plane.normal, up) < 0) plane.normal = -plane.normal;
    return plane;
}

std::optional<Vec3d> middle(const std::optional<Vec3d>& a, const std::optional<Vec3d>& b) {
    if (a && b) return 0.5 * (*a + *b);
    return std::nullopt;
}

/** The point nearest to the axes of the cameras: on the subject, roughly. */
std::optional<Vec3d> lookedAt(std::span<const Camerad> cameras) {
    std::vector<Ray> axes;
    for (const Camerad& camera : cameras) axes.push_back(pixelRay(camera, {camera.cx, camera.cy}));
    return pointNearRays(axes, std::vector<double>(axes.size(), 1.0), 0);
}

}  // namespace

std::optional<FloorPlane> findFloor(std::span<const Vec3d> points, std::span<const Camerad> stills, const Vec3d& up) {
    const double reach = reachOf(stills);
    double lowest = INFINITY;
    for (const Camerad& camera : stills) lowest = std::min(lowest, glm::dot(up, camera.eye()));
    std::vector<Vec3d> below;
    for (const Vec3d& p : points)
        if (glm::dot(up, p) < lowest && glm::length(p - stills[0].eye()) < 8 * reach) below.push_back(p);
    std::optional<FloorPlane> plane;
    Vec3d normal = up;
    for (double slab = kFirstSlab; slab >= kLastSlab; slab *= kSlabFactor) {
        std::vector<double> heights;
        for (const Vec3d& p : below) heights.push_back(glm::dot(normal, p));
        std::sort(heights.begin(), heights.end());
        size_t best = 0, count = 0;  // the slab with most points
        for (size_t i = 0, j = 0; i < heights.size(); ++i) {
            while (j < heights.size() && heights[j] <= heights[i] + slab * reach) ++j;
            if (j - i > count) count = j - i, best = i;
        }
        if (count < kFewestFloorPoints) return plane;
        std::vector<Vec3d> inside;
        for (const Vec3d& p : below)
            if (const double h = glm::dot(normal, p); h >= heights[best] && h <= heights[best] + slab * reach) inside.push_back(p);
        const FloorPlane next = planeThrough(inside, up);
        if (std::acos(std::clamp(glm::dot(next.normal, up), -1.0, 1.0)) > kMaxTiltRad) return plane;
        plane = next, normal = next.normal;
    }
    return plane;
}

std::optional<WorldFrame> findWorldFrame(const WorldEvidence& evidence) {
    const auto cameraUp = meanUp(evidence.stills);
    if (!cameraUp || evidence.stills.size() < 2) return std::nullopt;
    const StandingPoints& subject = evidence.subject;
    WorldFrame frame;
    Vec3d up = *cameraUp;
    const auto floor = findFloor(evidence.points, evidence.stills, up);
    if (floor) up = floor->normal;
    frame.floorFound = floor.has_value();

    std::optional<Vec3d> centre = middle(subject.hipL, subject.hipR);
    if (!centre) centre = middle(subject.ankleL, subject.ankleR);
    if (!centre) centre = lookedAt(evidence.stills);
    if (!centre) return std::nullopt;

    // Heights along up, in units of the cameras' world.
    std::optional<double> floorHeight, headHeight;
    if (subject.headTop) headHeight = glm::dot(up, *subject.headTop);
    if (floor)
        floorHeight = glm::dot(up, floor->point);
    else if (const auto ankles = middle(subject.ankleL, subject.ankleR)) {
        const double ankle = glm::dot(up, *ankles);
        floorHeight = headHeight ? ankle - kAnkleShare / (1 - kAnkleShare) * (*headHeight - ankle) : ankle;
    }
    double scale = 1;
    if (headHeight && floorHeight && *headHeight > *floorHeight) {
        scale = (evidence.heightM > 0 ? evidence.heightM : kAssumedHeightM) / (*headHeight - *floorHeight);
        frame.metric = evidence.heightM > 0;
    } else {
        scale = 2 / std::max(1e-9, reachOf(evidence.stills));  // a walk at two metres
    }

    Vec3d left(0);
    for (const auto& [l, r] : {std::pair{subject.shoulderL, subject.shoulderR}, {subject.hipL, subject.hipR}})
        if (l && r) left += *l - *r;
    left -= glm::dot(left, up) * up;
    frame.facingFound = glm::length(left) > 1e-9;
    if (!frame.facingFound) {  // the first picture of a walk usually shows the front
        const Vec3d toEye = evidence.stills[0].eye() - *centre;
        left = glm::cross(up, toEye);
        if (!(glm::length(left) > 1e-9)) return std::nullopt;
    }
    left = glm::normalize(left);
    const Vec3d front = glm::cross(left, up);
    frame.worldFromCameras.scale = scale;
    frame.worldFromCameras.rotation = glm::transpose(Mat3d(left, up, front));
    const Vec3d origin = *centre + (floorHeight.value_or(glm::dot(up, *centre)) - glm::dot(up, *centre)) * up;
    frame.worldFromCameras.translation = -scale * (frame.worldFromCameras.rotation * origin);
    return frame;
}

}  // namespace dpl
