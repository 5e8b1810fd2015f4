// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/refit.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/garments/body_follow.h"
#include "reconstruction/subject/garments/priors.h"
#include "reconstruction/subject/shape/smooth_mean.h"
#include "sdk/math/binding.h"

namespace dpl {
namespace {

constexpr float kReachM = 0.1f;             // depth in the body from which a vertex is still pushed out
constexpr float kLeastClearanceM = 0.001f;  // triangles are flat between vertices that keep this distance
constexpr float kBetweenGarmentsM = 0.003f;
constexpr double kPushSpreadM = 0.03;  // how far the neighbours of a pushed vertex follow
constexpr int kSmoothRounds = 8, kExactRounds = 16;

/** Polar rotation of each triangle from one body to the other. */
std::vector<Mat3f> turns(std::span<const Vec3f> from, std::span<const Vec3f> to, std::span<const Triangle> triangles) {
    std::vector<Mat3f> out;
    for (const Triangle& t : triangles) {
        const auto frame = poseTriangle(restTriangle(Vec3d(from[t.x]), Vec3d(from[t.y]), Vec3d(from[t.z])), Vec3d(to[t.x]), Vec3d(to[t.y]),
                                        Vec3d(to[t.z]));
        out.push_back(frame.valid ? Mat3f(frame.worldFromRest) : Mat3f(1));
    }
    return out;
}

}  // namespace

Result<CarriedGarment> carryGarment(const SurfaceMesh& garment, std::span<const Vec3f> oldBody, std::span<const Vec3f> newBody,
                                    std::span<const Triangle> bodyTriangles) {
    const ClosestSurface surface(oldBody, bodyTriangles);
    const std::vector<SurfacePoint> below = bodyBelow(garment, surface);
    const std::vector<Mat3f> turn = turns(oldBody, newBody, bodyTriangles);
    const size_t count = garment.positions.size();
    CarriedGarment out{garment.positions, {}};
    std::vector<double> moves(count * 3);
    for (size_t v = 0; v < count; ++v) {
        const Triangle& t = bodyTriangles[below[v].triangle];
        const Vec3f w = below[v].barycentric, p = garment.positions[v];
        const Vec3f foot = w.x * newBody[t.x] + w.y * newBody[t.y] + w.z * newBody[t.z];
        const Vec3f move = foot + turn[below[v].triangle] * (p - below[v].position) - p;
        for (int k = 0; k < 3; ++k) moves[v * 3 + size_t(k)] = double(move[k]);
        const float clearance = std::min(surface.signedDistance(p, kReachM), float(priors::kBodyBelowClothM));
        out.clearanceM.push_back(std::max(kLeastClearanceM, clearance));
    }
    DPL_TRY(const std::vector<double> spread, followBody(garment, followLengths(below), moves, 3));
    for (size_t v = 0; v < count; ++v) out.positions[v] += Vec3f(float(spread[v * 3]), float(spread[v * 3 + 1]), float(spread[v * 3 + 2]));
    return out;
}

Result<uint32_t> pushOut(const Obstacles& obstacles, std::span<const float> clearanceM, SurfaceMesh& garment) {
    std::vector<Vec3f>& at = garment.positions;
    DPL_TRY(const LargeSteps smooth, LargeSteps::create(at, garment.triangles, kPushSpreadM));
    const std::vector<Vec3f> normals = vertexNormals(at, garment.triangles);
    uint32_t inside = 0;
    for (int round = 0; round < kSmoothRounds + kExactRounds; ++round) {
        std::vector<Vec3f> push(at.size(), Vec3f(0));
        std::vector<float> pushed(at.size(), 0.0f);
        bool any = false;
        for (size_t v = 0; v < at.size(); ++v) {
            const auto lift = [&](const GarmentCover& cover, float side) {  // side: 1 over the cover, −1 under it
                const auto height = cover.heightOf(at[v], normals[v]);
                const float need = height ? kBetweenGarmentsM - side * height->aboveM : 0;
                if (need > glm::length(push[v])) push[v] = side * need * height->normal, pushed[v] = 1;
            };
            if (!obstacles.tucked[v]) {
                for (const GarmentCover& cover : obstacles.below) lift(cover, 1);
                for (const GarmentCover& cover : obstacles.above) lift(cover, -1);
            }
            const Vec3f wanted = at[v] + push[v];
            const float distance = obstacles.body.signedDistance(wanted, kReachM);
            if (distance < clearanceM[v]) {
                const SurfacePoint foot = obstacles.body.find(wanted);
                const Vec3f out = foot.distanceM > 1e-5f ? (distance < 0 ? foot.position - wanted : wanted - foot.position) / foot.distanceM
                                                         : obstacles.body.normalAt(foot);
                push[v] += (clearanceM[v] - distance + 1e-5f) * out;
                pushed[v] = 1;
            }
            any |= pushed[v] > 0 && glm::length(push[v]) > 1e-5f;
        }
        if (!any) break;
        const std::vector<Vec3f> follow = round < kSmoothRounds ? smoothMean(smooth, push, pushed, 0.05f) : push;
        for (size_t v = 0; v < at.size(); ++v) at[v] += follow[v];
    }
    for (const Vec3f& p : at) inside += obstacles.body.signedDistance(p, kReachM) < 0;
    return inside;
}

}  // namespace dpl
