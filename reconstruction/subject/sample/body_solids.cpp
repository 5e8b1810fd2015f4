// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/body_solids.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "reconstruction/subject/sample/field.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/subject.h"

namespace dpl {
namespace {

constexpr float kReach = float(BodySolids::kReachM);
constexpr float kHeadStepM = 0.007f, kTrunkStepM = 0.009f;

/** Before the face, from the eyes to the throat: hair hangs beside it. */
float faceSpace(const Vec3f& head, const Vec3f& p) {
    return taperedCapsule(p, head + Vec3f(0, 0.065f, 0.088f), head + Vec3f(0, -0.075f, 0.095f), 0.060f, 0.050f);
}

ClosestSurface surfaceOf(const Subject& subject, const LayerData& layer) {
    const auto& mesh = subject.mesh;
    std::vector<Triangle> triangles(mesh.triangles.begin() + layer.firstTriangle,
                                    mesh.triangles.begin() + layer.firstTriangle + layer.triangleCount);
    for (Triangle& t : triangles) t -= layer.firstVertex;
    return {std::span(mesh.restPositions).subspan(layer.firstVertex, layer.vertexCount), triangles};
}

/** Per vertex of a layer: 1 on its borders. */
std::vector<uint8_t> borderOf(const Subject& subject, const LayerData& layer) {
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t)
        for (int c = 0; c < 3; ++c) ++uses[std::minmax(subject.mesh.triangles[t][c], subject.mesh.triangles[t][(c + 1) % 3])];
    std::vector<uint8_t> border(layer.vertexCount, 0);
    for (const auto& [edge, count] : uses)
        if (count == 1) border[edge.first - layer.firstVertex] = border[edge.second - layer.firstVertex] = 1;
    return border;
}

DistanceGrid headGrid(const Subject& subject, const ClosestSurface& skin, Jobs& jobs) {
    const Vec3f head = subject.joints[kHead].restPosition;
    return {head + Vec3f(-0.16f, -0.12f, -0.17f),
            head + Vec3f(0.16f, 0.26f, 0.20f),
            kHeadStepM,
            kReach,
            [&](const Vec3f& p) { return std::min(skin.signedDistance(p, kReach), faceSpace(head, p)); },
            jobs};
}

DistanceGrid trunkGrid(const Subject& subject, const ClosestSurface& skin, Jobs& jobs) {
    const Vec3f neck = subject.joints[kNeck].restPosition;
    size_t top = 0;
    while (subject.parts[top].label != kLabelTop) ++top;
    const LayerData& layer = subject.mesh.layers[top];
    const ClosestSurface shirt = surfaceOf(subject, layer);
    const std::vector<uint8_t> border = borderOf(subject, layer);
    const auto distance = [&](const Vec3f& p) {
        const float off = skin.signedDistance(p, kReach);
        const SurfacePoint near = shirt.find(p, kReach);
        if (!near.found()) return off;
        // Beyond a border, which side of the cloth a point is on says nothing.
        const Triangle& f = subject.mesh.triangles[layer.firstTriangle + near.triangle] - layer.firstVertex;
        if (border[f.x] || border[f.y] || border[f.z]) return std::min(off, near.distanceM);
        return std::min(off, shirt.isInside(p, near) ? -near.distanceM : near.distanceM);
    };
    return {neck + Vec3f(-0.21f, -0.42f, -0.22f), neck + Vec3f(0.21f, 0.07f, 0.24f), kTrunkStepM, kReach, distance, jobs};
}

/** How far p is outside of a capsule whose radius changes along it. */
double outsideCapsule(const Vec3d& p, const std::array<Vec3d, 2>& ends, const std::array<double, 2>& radiusM, Vec3d& outward) {
    const Vec3d along = ends[1] - ends[0];
    const double t = std::clamp(glm::dot(p - ends[0], along) / glm::dot(along, along), 0.0, 1.0);
    const Vec3d off = p - ends[0] - t * along;
    const double length = glm::length(off);
    outward = length > 1e-9 ? off / length : Vec3d(0, 1, 0);
    return length - glm::mix(radiusM[0], radiusM[1], t);
}

}  // namespace

DistanceGrid::DistanceGrid(const Vec3f& low, const Vec3f& high, float stepM, float reachM,
                           const std::function<float(const Vec3f&)>& distance, Jobs& jobs)
    : low_(low), stepM_(double(stepM)), reachM_(double(reachM)), count_(glm::ivec3((high - low) / stepM) + 2) {
    values_.resize(size_t(count_.x) * size_t(count_.y) * size_t(count_.z));
    jobs.forBlocks(size_t(count_.z), [&](size_t z, uint32_t) {
        for (int y = 0; y < count_.y; ++y)
            for (int x = 0; x < count_.x; ++x) {
                const float d = distance(low + stepM * Vec3f(float(x), float(y), float(z)));
                values_[(z * size_t(count_.y) + size_t(y)) * size_t(count_.x) + size_t(x)] = std::clamp(d, -reachM, reachM);
            }
    });
}

double DistanceGrid::at(const Vec3d& p, Vec3d& gradient) const {
    gradient = Vec3d(0);
    const Vec3d place = (p - low_) / stepM_;
    for (int c = 0; c < 3; ++c)
        if (!(place[c] >= 0) || place[c] >= count_[c] - 1) return reachM_;
    const glm::ivec3 cell(place);
    const Vec3d t = place - Vec3d(cell);
    const size_t row = size_t(count_.x), sheet = row * size_t(count_.y);
    const float* v = &values_[size_t(cell.z) * sheet + size_t(cell.y) * row + size_t(cell.x)];
    double sum = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        const size_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const double value = double(v[x + y * row + z * sheet]);
        const Vec3d w(x ? t.x : 1 - t.x, y ? t.y : 1 - t.y, z ? t.z : 1 - t.z);
        sum += value * w.x * w.y * w.z;
        gradient += value * Vec3d(x ? w.y * w.z : -w.y * w.z, y ? w.x * w.z : -w.x * w.z, z ? w.x * w.y : -w.x * w.y);
    }
    gradient /= stepM_;
    return sum;
}

BodySolids::BodySolids(const Subject& subject, Jobs& jobs) : BodySolids(subject, surfaceOf(subject, subject.mesh.layers[0]), jobs) {}

BodySolids::BodySolids(const Subject& subject, const ClosestSurface& skin, Jobs& jobs)
    : head_(headGrid(subject, skin, jobs)), trunk_(trunkGrid(subject, skin, jobs)) {
    for (size_t side = 0; side < 2; ++side)
        upperArms_[side] = {Vec3d(subject.joints[kLeftShoulder + side].restPosition),
                            Vec3d(subject.joints[kLeftElbow + side].restPosition)};
}

PosedSolids::PosedSolids(const BodySolids& solids, const std::vector<Mat3x4d>& worldFromRest)
    : solids_(solids), head_(worldFromRest[kHead]), trunk_(worldFromRest[kSpine3]) {
    for (size_t side = 0; side < 2; ++side)
        for (size_t end = 0; end < 2; ++end)
            upperArms_[side][end] = transformed(worldFromRest[kLeftShoulder + side], solids.upperArms_[side][end]);
}

PosedSolids::Near PosedSolids::nearest(const Vec3d& p) const {
    Near near{BodySolids::kReachM, Vec3d(0)};
    Vec3d outward;
    const auto grid = [&](const DistanceGrid& solid, const Mat3x4d& worldFromRest) {
        const Mat3d turn(worldFromRest[0], worldFromRest[1], worldFromRest[2]);
        const double d = solid.at((p - worldFromRest[3]) * turn, outward);
        if (d >= near.distanceM) return;
        const double length = glm::length(outward);
        if (length > 1e-6) near = {d, turn * outward / length};
    };
    grid(solids_.head_, head_);
    grid(solids_.trunk_, trunk_);
    for (const auto& arm : upperArms_) {
        const double d = outsideCapsule(p, arm, solids_.armRadiusM_, outward);
        if (d < near.distanceM) near = {d, outward};
    }
    return near;
}

}  // namespace dpl
