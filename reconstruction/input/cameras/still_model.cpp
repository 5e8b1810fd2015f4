// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/still_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <set>

#include "reconstruction/input/cameras/priors.h"
#include "reconstruction/input/cameras/rays.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr double kMinParallaxRad = 0.02;  // of a triangulated point
constexpr size_t kAnchors = 12;           // still pictures that an unplaced picture is first matched with
constexpr size_t kNearest = 5;            // and, once its camera is roughly known, with this many nearest ones
constexpr double kRansacPx = 4;
constexpr int kRansacRounds = 2000;
constexpr size_t kFewestForRansac = 8;

Vec3d forward(const Camerad& camera) {
    return glm::transpose(camera.viewFromWorldRotation) * Vec3d(0, 0, 1);
}

/** Smaller for cameras that see more of the same. `spread`: the size of the scene. */
double viewDistance(const Camerad& a, const Camerad& b, double spread) {
    const double turn = std::acos(std::clamp(glm::dot(forward(a), forward(b)), -1.0, 1.0));
    return turn + glm::length(a.eye() - b.eye()) / spread;
}

double spreadOf(std::span<const Camerad> cameras) {
    Vec3d mean(0);
    for (const Camerad& camera : cameras) mean += camera.eye() / double(cameras.size());
    double square = 0;
    for (const Camerad& camera : cameras) square += glm::dot(camera.eye() - mean, camera.eye() - mean) / double(cameras.size());
    return std::max(1e-9, std::sqrt(square));
}

/** Distance of pixel `b` from the line on which camera B shows the ray through pixel `a` of camera A, px. */
double lineDistance(const Camerad& cameraA, const Vec2d& a, const Camerad& cameraB, const Vec2d& b) {
    const Ray ray = pixelRay(cameraA, a);
    const Mat3d& r = cameraB.viewFromWorldRotation;
    const Vec3d direction = r * ray.direction, eye = cameraB.toView(ray.origin);
    const Vec3d normal = glm::cross(eye, direction);  // of the plane through both eyes and the ray, in view B
    // The line in pixels: normal · ((u − cx)/fx, (v − cy)/fy, 1) = 0.
    const Vec2d slope(normal.x / cameraB.fx, normal.y / cameraB.fy);
    const double value = slope.x * (b.x - cameraB.cx) + slope.y * (b.y - cameraB.cy) + normal.z;
    const double length = glm::length(slope);
    return length > 0 ? std::abs(value) / length : 0;
}

/** Features joined by matches, as a forest. */
class Joined {
public:
    explicit Joined(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), size_t(0)); }
    size_t rootOf(size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(size_t a, size_t b) { parent_[std::max(rootOf(a), rootOf(b))] = std::min(rootOf(a), rootOf(b)); }

private:
    std::vector<size_t> parent_;
};

struct Seen {
    uint32_t picture, feature;
};

/** The point of a track, or nullopt: too little parallax, behind a camera, or too far from a feature. */
std::optional<Vec3d> triangulate(const std::vector<Seen>& track, std::span<const StillPicture> pictures,
                                 const std::vector<std::vector<Vec2d>>& pinhole, double missPx) {
    std::vector<Ray> rays;
    double parallax = 0;
    for (const Seen& seen : track) {
        rays.push_back(pixelRay(pictures[seen.picture].camera, pinhole[seen.picture][seen.feature]));
        parallax = std::max(parallax, std::acos(std::clamp(glm::dot(rays.front().direction, rays.back().direction), -1.0, 1.0)));
    }
    if (parallax < kMinParallaxRad) return std::nullopt;
    // pointNearRays() treats rays of little parallax as parallel, so the directions are compared above and the sum is solved here.
    Mat3d a(0.0);
    Vec3d b(0);
    for (const Ray& ray : rays) {
        const Mat3d across = Mat3d(1.0) - glm::outerProduct(ray.direction, ray.direction);
        a += across, b += across * ray.origin;
    }
    const Vec3d point = glm::inverse(a) * b;
    for (const Seen& seen : track) {
        const Camerad& camera = pictures[seen.picture].camera;
        const Vec3d view = camera.toView(point);
        if (!(view.z > 0) || !(glm::length(camera.pixelOf(view) - pinhole[seen.picture][seen.feature]) <= missPx)) return std::nullopt;
    }
    return point;
}

/** Pairs of a picture's features with points, found by matching it with some still pictures. */
std::map<uint32_t, uint32_t> pointsSeen(const Features& features, std::span<const size_t> with, const Tracks& tracks) {
    std::map<uint32_t, uint32_t> points;
    for (const size_t still : with)
        for (const FeatureMatch& match : matchFeatures(features, tracks.seen[still]))
            points.emplace(match.a, tracks.pointOfSeen[still][match.b]);
    return points;
}

std::optional<PlacedCamera> placeFrom(const std::map<uint32_t, uint32_t>& points, const Features& features, const Camerad& intrinsics,
                                      const Tracks& tracks) {
    if (points.size() < kFewestForRansac) return std::nullopt;
    BundleScene scene;
    scene.cameras = {intrinsics};
    scene.lens = tracks.scene.lens;
    std::vector<cv::Point3d> world;
    std::vector<cv::Point2d> image;
    std::vector<Vec2d> stored;
    for (const auto& [feature, point] : points) stored.push_back(features.px[feature]);
    const std::vector<Vec2d> pinhole = pinholePixels(stored, intrinsics, scene.lens);
    size_t i = 0;
    for (const auto& [feature, point] : points) {
        const Vec3d& p = tracks.scene.points[point];
        world.emplace_back(p.x, p.y, p.z), image.emplace_back(pinhole[i].x, pinhole[i].y);
        scene.points.push_back(p);
        ++i;
    }
    const cv::Matx33d k(intrinsics.fx, 0, intrinsics.cx, 0, intrinsics.fy, intrinsics.cy, 0, 0, 1);
    cv::Vec3d rotation, translation;
    std::vector<int> inliers;
    if (!cv::solvePnPRansac(world, image, k, cv::noArray(), rotation, translation, false, kRansacRounds, float(kRansacPx), 0.9999, inliers,
                            cv::SOLVEPNP_AP3P) ||
        inliers.size() < kFewestInliers)
        return std::nullopt;
    cv::Matx33d matrix;
    cv::Rodrigues(rotation, matrix);
    Camerad& camera = scene.cameras[0];
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) camera.viewFromWorldRotation[c][r] = matrix(r, c);
    camera.viewFromWorldTranslation = {translation[0], translation[1], translation[2]};
    for (const int index : inliers) scene.observations.push_back({0, uint32_t(index), stored[size_t(index)]});
    BundleSettings settings;
    settings.fixedPoints = true;
    const auto end = adjustBundle(scene, settings);
    if (!end || end->used < kFewestInliers) return std::nullopt;
    return PlacedCamera{scene.cameras[0], end->used, end->missAfterPx};
}

}  // namespace

std::vector<size_t> nearestTo(const Camerad& camera, std::span<const Camerad> cameras, size_t count) {
    const double spread = spreadOf(cameras);
    std::vector<size_t> order(cameras.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::vector<double> distance;
    for (const Camerad& other : cameras) distance.push_back(viewDistance(camera, other, spread));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return distance[a] < distance[b]; });
    order.resize(std::min(order.size(), count));
    return order;
}

std::vector<std::pair<uint32_t, uint32_t>> nearPairs(std::span<const Camerad> cameras, size_t nearest) {
    std::set<std::pair<uint32_t, uint32_t>> pairs;
    for (size_t i = 0; i < cameras.size(); ++i)
        for (const size_t j : nearestTo(cameras[i], cameras, nearest + 1))
            if (i != j) pairs.emplace(uint32_t(std::min(i, j)), uint32_t(std::max(i, j)));
    return {pairs.begin(), pairs.end()};
}

Result<Tracks> findTracks(std::span<const StillPicture> pictures, const LensDistortion& lens, const TrackSettings& settings) {
    Tracks out;
    out.scene.lens = lens;
    std::vector<std::vector<Vec2d>> pinhole;
    std::vector<size_t> first(pictures.size() + 1, 0);  // number of the first feature of each picture
    for (size_t p = 0; p < pictures.size(); ++p) {
        out.scene.cameras.push_back(pictures[p].camera);
        pinhole.push_back(pinholePixels(pictures[p].features.px, pictures[p].camera, lens));
        first[p + 1] = first[p] + pictures[p].features.size();
    }
    out.matchesOfPicture.assign(pictures.size(), 0);
    out.seen.resize(pictures.size()), out.pointOfSeen.resize(pictures.size());
    Joined joined(first.back());
    std::vector<double> misses;
    auto pairs = nearPairs(out.scene.cameras, settings.nearest);
    pairs.insert(pairs.end(), settings.morePairs.begin(), settings.morePairs.end());
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    for (size_t i = 0; i < pairs.size(); ++i) {
        const auto [a, b] = pairs[i];
        for (const FeatureMatch& match : matchFeatures(pictures[a].features, pictures[b].features)) {
            const Vec2d &pa = pinhole[a][match.a], &pb = pinhole[b][match.b];
            const double miss = std::max(lineDistance(pictures[a].camera, pa, pictures[b].camera, pb),
                                         lineDistance(pictures[b].camera, pb, pictures[a].camera, pa));
            if (!(miss <= settings.epipolarPx)) continue;
            misses.push_back(miss);
            ++out.matchesOfPicture[a], ++out.matchesOfPicture[b];
            joined.join(first[a] + match.a, first[b] + match.b);
        }
        DPL_RETURN_IF_ERROR(taskAt(double(i + 1) / double(pairs.size()), "points of the background"));
    }
    out.epipolarMissPx = percentile(misses, 0.5);

    std::map<size_t, std::vector<Seen>> tracks;  // by their root, so in a fixed order
    for (size_t p = 0; p < pictures.size(); ++p)
        for (size_t f = 0; f < pictures[p].features.size(); ++f) tracks[joined.rootOf(first[p] + f)].push_back({uint32_t(p), uint32_t(f)});
    for (const auto& [root, track] : tracks) {
        if (track.size() < 2) continue;
        // A picture shows a point once. A track that says otherwise joins different points.
        const bool twice = std::adjacent_find(track.begin(), track.end(),
                                              [](const Seen& a, const Seen& b) { return a.picture == b.picture; }) != track.end();
        if (twice) continue;
        const auto point = triangulate(track, pictures, pinhole, settings.missPx);
        if (!point) continue;
        const auto index = uint32_t(out.scene.points.size());
        out.scene.points.push_back(*point);
        for (const Seen& seen : track) {
            const Features& from = pictures[seen.picture].features;
            Features& to = out.seen[seen.picture];
            out.scene.observations.push_back({seen.picture, index, from.px[seen.feature]});
            to.px.push_back(from.px[seen.feature]);
            const auto bytes = from.descriptors.begin() + std::ptrdiff_t(size_t(seen.feature) * kFeatureBytes);
            to.descriptors.insert(to.descriptors.end(), bytes, bytes + kFeatureBytes);
            out.pointOfSeen[seen.picture].push_back(index);
        }
    }
    return out;
}

std::optional<PlacedCamera> placePicture(const Features& features, const Camerad& intrinsics, const Tracks& tracks, const Camerad* near) {
    const size_t stills = tracks.seen.size(), anchors = std::min(kAnchors, stills);
    const auto placeWith = [&](const std::vector<size_t>& with) {
        return placeFrom(pointsSeen(features, with, tracks), features, intrinsics, tracks);
    };
    std::optional<PlacedCamera> placed;
    if (near) placed = placeWith(nearestTo(*near, tracks.scene.cameras, kNearest));
    if (placed && placed->inliers >= priors::kSureMatches) return placed;
    std::vector<size_t> with;
    for (size_t i = 0; i < anchors; ++i) with.push_back(i * stills / anchors);
    auto wide = placeWith(with);
    if (!wide) return placed;
    const auto better = placeWith(nearestTo(wide->camera, tracks.scene.cameras, kNearest));
    if (better && better->inliers >= wide->inliers) wide = better;
    if (!placed || wide->inliers > placed->inliers) placed = wide;
    return placed;
}

}  // namespace dpl
