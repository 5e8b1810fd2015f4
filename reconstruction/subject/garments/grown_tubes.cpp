// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/grown_tubes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "reconstruction/subject/surface/clothed_layers.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr float kTau = 6.2831853f;
constexpr size_t kLeastVertices = 4;
constexpr float kShortestM = 0.01f;
constexpr uint32_t kNone = ~0u;
constexpr double kLeastShare = 0.01;  // of a garment: of joints whose tubes it may stand on

/** Joint that has most of a vertex; the first of equals. */
size_t ownerOf(const MeshData& mesh, size_t vertex) {
    int best = 0;
    for (int i = 1; i < 4; ++i)
        if (mesh.jointWeights[vertex][i] > mesh.jointWeights[vertex][best]) best = i;
    return mesh.jointIndices[vertex][best];
}

/** Share of each joint in the weights of a layer. */
std::vector<double> jointShares(size_t jointCount, const MeshData& mesh, const LayerData& layer) {
    std::vector<double> shares(jointCount, 0);
    for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
        for (int i = 0; i < 4; ++i) shares[mesh.jointIndices[v][i]] += double(mesh.jointWeights[v][i]) / 255 / double(layer.vertexCount);
    return shares;
}

/** The direction in which points spread most. */
Vec3f longestAxis(std::span<const Vec3f> points, const Vec3f& middle) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Vec3f& p : points) {
        const Eigen::Vector3d d(p.x - middle.x, p.y - middle.y, p.z - middle.z);
        spread += d * d.transpose();
    }
    const Eigen::Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
    return glm::normalize(Vec3f(float(axis.x()), float(axis.y()), float(axis.z())));
}

}  // namespace

void GrownTubes::Shell::enclose(const Place& place) {
    beginM = empty ? place.alongM : std::min(beginM, place.alongM), endM = empty ? place.alongM : std::max(endM, place.alongM);
    empty = false;
    const size_t a0 = size_t((place.angleRad / kTau + 1) * float(kAround)) % kAround;
    for (const size_t a : {a0, (a0 + 1) % kAround}) radiiM[a] = std::max(radiiM[a], place.radiusM);
}

GrownTubes::Tube GrownTubes::Tube::around(size_t joint, std::span<const Vec3f> points) {
    Tube tube;
    tube.joint = joint;
    for (const Vec3f& p : points) tube.from += p / float(points.size());
    tube.along = longestAxis(points, tube.from);
    const Vec3f side = std::abs(tube.along.z) < 0.9f ? Vec3f(0, 0, 1) : Vec3f(1, 0, 0);
    tube.across = glm::normalize(side - tube.along * glm::dot(side, tube.along));
    tube.third = glm::cross(tube.along, tube.across);
    tube.stretchTo(points);
    tube.enclose(points, tube.body);
    return tube;
}

GrownTubes::Place GrownTubes::Tube::placeOf(const Vec3f& p) const {
    const Vec3f d = p - from;
    const float x = glm::dot(d, across), y = glm::dot(d, third);
    return {glm::dot(d, along), std::hypot(x, y), std::atan2(y, x)};
}

size_t GrownTubes::Tube::pieceAt(float alongM) const {
    return size_t(std::clamp((alongM - beginM) / (endM - beginM) * float(kPieces), 0.0f, float(kPieces) - 0.5f));
}

void GrownTubes::Tube::stretchTo(std::span<const Vec3f> points) {
    for (const Vec3f& p : points) beginM = std::min(beginM, placeOf(p).alongM), endM = std::max(endM, placeOf(p).alongM);
}

void GrownTubes::Tube::enclose(std::span<const Vec3f> points, std::array<Shell, kPieces>& shells) const {
    shells = {};
    for (const Vec3f& p : points) {
        const Place place = placeOf(p);
        shells[pieceAt(place.alongM)].enclose(place);
    }
}

float GrownTubes::Tube::distanceM(const Vec3f& p) const {
    const Place place = placeOf(p);
    const float beyond = std::max({beginM - place.alongM, place.alongM - endM, 0.0f});
    const size_t a = size_t((place.angleRad / kTau + 1) * float(kAround) + 0.5f) % kAround;
    return std::hypot(std::max(0.0f, place.radiusM - body[pieceAt(place.alongM)].radiiM[a]), beyond);
}

void GrownTubes::join(const MeshData& mesh, const LayerData& layer, bool cloth, std::span<const uint32_t> tubeAt) {
    const auto pieceOf = [&](uint32_t v) {
        const Tube& tube = tubes_[tubeAt[v]];
        return Piece{cloth, tubeAt[v], uint32_t(tube.pieceAt(tube.placeOf(mesh.restPositions[v]).alongM))};
    };
    for (uint32_t i = 0; i < layer.triangleCount; ++i) {
        const Triangle& t = mesh.triangles[layer.firstTriangle + i];
        for (int c = 0; c < 3; ++c) {
            const uint32_t a = t[c], b = t[(c + 1) % 3];
            if (tubeAt[a] == kNone || tubeAt[b] == kNone) continue;
            const auto [low, high] = std::minmax({pieceOf(a), pieceOf(b)});
            if (low != high) joined_.push_back({low, high});
        }
    }
    std::sort(joined_.begin(), joined_.end());
    joined_.erase(std::unique(joined_.begin(), joined_.end()), joined_.end());
}

GrownTubes::GrownTubes(std::span<const JointData> joints, const MeshData& mesh, const LayerData& garment) {
    const LayerData* body = bodyLayer(mesh);
    if (!body) return;
    std::vector<uint32_t> tubeAt(mesh.restPositions.size(), kNone);
    std::vector<std::vector<uint32_t>> own(joints.size());
    const auto placesOf = [&](std::span<const uint32_t> vertices) {
        std::vector<Vec3f> places;
        for (const uint32_t v : vertices) places.push_back(mesh.restPositions[v]);
        return places;
    };
    for (uint32_t v = body->firstVertex; v < body->firstVertex + body->vertexCount; ++v) own[ownerOf(mesh, v)].push_back(v);
    for (size_t j = 0; j < joints.size(); ++j) {
        if (own[j].size() < kLeastVertices) continue;
        Tube tube = Tube::around(j, placesOf(own[j]));
        if (tube.endM - tube.beginM < kShortestM) continue;
        for (const uint32_t v : own[j]) tubeAt[v] = uint32_t(tubes_.size());
        tubes_.push_back(std::move(tube));
    }
    if (tubes_.empty()) return;
    const std::vector<double> shares = jointShares(joints.size(), mesh, garment);
    const bool any = std::any_of(tubes_.begin(), tubes_.end(), [&](const Tube& tube) { return shares[tube.joint] >= kLeastShare; });
    std::vector<std::vector<uint32_t>> cloth(tubes_.size());
    for (uint32_t v = garment.firstVertex; v < garment.firstVertex + garment.vertexCount; ++v) {
        float nearest = std::numeric_limits<float>::infinity();
        for (uint32_t t = 0; t < tubes_.size(); ++t) {
            if (any && shares[tubes_[t].joint] < kLeastShare) continue;
            const float distance = tubes_[t].distanceM(mesh.restPositions[v]);
            if (distance < nearest) nearest = distance, tubeAt[v] = t;
        }
        cloth[tubeAt[v]].push_back(v);
    }
    for (size_t t = 0; t < tubes_.size(); ++t) {
        const std::vector<Vec3f> clothPlaces = placesOf(cloth[t]);
        tubes_[t].stretchTo(clothPlaces);  // a hem may hang below the foot
        tubes_[t].enclose(placesOf(own[tubes_[t].joint]), tubes_[t].body);
        tubes_[t].enclose(clothPlaces, tubes_[t].cloth);
    }
    join(mesh, *body, /*cloth=*/false, tubeAt);
    join(mesh, garment, /*cloth=*/true, tubeAt);
}

std::vector<uint8_t> GrownTubes::outline(std::span<const Mat3x4f> worldFromRest, const Camerad& camera) const {
    const float widen = 1 / std::cos(0.5f * kTau / float(kAround));  // the polygon of a ring lies around its circle
    const auto cornersOf = [&](const Tube& tube, const Shell& shell) {
        std::vector<cv::Point2f> corners, hull;
        for (size_t i = 0; i < 2 * kAround && !shell.empty; ++i) {
            const float angle = kTau * float(i % kAround) / float(kAround), radius = widen * shell.radiiM[i % kAround];
            const Vec3f rest = tube.from + (i < kAround ? shell.beginM : shell.endM) * tube.along +
                               radius * (std::cos(angle) * tube.across + std::sin(angle) * tube.third);
            const Vec3d view =
                camera.viewFromWorldRotation * Vec3d(worldFromRest[tube.joint] * Vec4f(rest, 1)) + camera.viewFromWorldTranslation;
            if (view.z < kNearM) continue;
            const Vec2d pixel = camera.pixelOf(view);
            corners.push_back({float(pixel.x), float(pixel.y)});
        }
        if (!corners.empty()) cv::convexHull(corners, hull);
        return hull;
    };
    std::vector<std::vector<cv::Point2f>> drawn[2];  // body, cloth: corners of each tube's pieces
    for (const Tube& tube : tubes_)
        for (size_t k = 0; k < kPieces; ++k)
            drawn[0].push_back(cornersOf(tube, tube.body[k])), drawn[1].push_back(cornersOf(tube, tube.cloth[k]));
    cv::Mat picture(int(camera.heightPx), int(camera.widthPx), CV_8U, cv::Scalar(0));
    const auto fill = [&](std::initializer_list<Piece> pieces) {
        std::vector<cv::Point2f> corners, hull;
        for (const Piece& p : pieces) {
            const auto& own = drawn[p.cloth][p.tube * kPieces + p.piece];
            corners.insert(corners.end(), own.begin(), own.end());
        }
        if (corners.empty()) return;
        cv::convexHull(corners, hull);
        constexpr int kShift = 4;  // bits of a pixel's fraction
        std::vector<cv::Point> rounded;
        for (const cv::Point2f& p : hull)  // our pixel centres lie at +0.5, those of OpenCV at whole numbers
            rounded.push_back({int(std::lround((p.x - 0.5f) * (1 << kShift))), int(std::lround((p.y - 0.5f) * (1 << kShift)))});
        cv::fillConvexPoly(picture, rounded, cv::Scalar(1), cv::LINE_8, kShift);
    };
    for (uint32_t t = 0; t < tubes_.size(); ++t)
        for (uint32_t k = 0; k < kPieces; ++k) fill({{false, t, k}}), fill({{true, t, k}});
    for (const auto& [a, b] : joined_) fill({a, b});
    return {picture.datastart, picture.dataend};
}

}  // namespace dpl
