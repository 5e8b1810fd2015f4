// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/without_gate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "reconstruction/output/package/avatar_drawer.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr uint32_t kSidePx = 512, kSides = 8, kFits = 2;
constexpr double kElevationsRad[] = {-0.35, 0.1, 0.6};
constexpr double kNearM = 0.7, kHeadShare = 0.15;  // the head: the top of the body, looked at from as near as people come
constexpr float kWhole = 0.9f;                     // larger factors are grazing views, where the gate fades the outside; it stays whole

std::vector<Cameraf> viewsOf(std::span<const Vec3f> vertices) {
    Vec3f low(0), high(0);
    if (!vertices.empty()) low = high = vertices[0];
    for (const Vec3f& v : vertices) low = glm::min(low, v), high = glm::max(high, v);
    Vec3d head(0);
    double count = 0;
    for (const Vec3f& v : vertices)
        if (v.y > high.y - float(kHeadShare) * (high.y - low.y)) head += Vec3d(v), ++count;
    std::vector<Cameraf> views;
    for (uint32_t side = 0; side < kSides; ++side) {
        const double azimuth = 2 * std::numbers::pi * side / kSides;
        for (const double elevation : kElevationsRad) views.push_back(orbitBox(low, high, azimuth, elevation, kSidePx).cast<float>());
        if (count > 0) views.push_back(orbitCamera(head / count, kNearM, azimuth, 0.1, kSidePx, kSidePx, kSidePx).cast<float>());
    }
    return views;
}

/** What each splat adds to each view. */
std::vector<std::vector<double>> contributions(const AvatarData& avatar, const ClothLimits& cloth, const Pose& pose,
                                               std::span<const Cameraf> views, Jobs& jobs) {
    std::vector<std::vector<double>> out(views.size(), std::vector<double>(avatar.splats.count(), 0.0));
    std::vector<std::unique_ptr<Jobs>> alone(jobs.threadCount());
    std::vector<std::unique_ptr<AvatarDrawer>> drawers(jobs.threadCount());
    jobs.forBlocks(views.size(), [&](size_t v, uint32_t worker) {
        if (!drawers[worker])
            alone[worker] = std::make_unique<Jobs>(1), drawers[worker] = std::make_unique<AvatarDrawer>(avatar, *alone[worker], &cloth);
        addContributions(drawers[worker]->project(pose, views[v]), views[v], out[v]);
    });
    return out;
}

}  // namespace

Result<std::vector<float>> opacityWithoutGate(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs) {
    const size_t count = avatar.splats.count();
    std::vector<float> factor(count, 1.0f);
    if (std::none_of(avatar.splats.flags.begin(), avatar.splats.flags.end(), [](uint8_t f) { return (f & kSplatSingleFace) != 0; }))
        return factor;
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    AvatarData ungated = avatar;
    for (uint8_t& flags : ungated.splats.flags) flags &= uint8_t(~kSplatSingleFace);

    size_t done = 0;
    const auto look = [&] { return taskAt(double(done++) / double(poses.size() * (1 + kFits)), "looking at what shows without the gate"); };
    std::vector<std::vector<Cameraf>> views;
    std::vector<std::vector<std::vector<double>>> gatedAdds;  // pose, view, splat
    for (const Pose& pose : poses) {
        DPL_RETURN_IF_ERROR(look());
        PosedMesh posed;
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, &avatar.light, {}, &cloth}, pose, jobs);
        views.push_back(viewsOf(posed.positions()));
        gatedAdds.push_back(contributions(avatar, cloth, pose, views.back(), jobs));
    }
    for (uint32_t fit = 0; fit < kFits; ++fit) {
        std::vector<double> both(count, 0.0), own(count, 0.0);  // Σ u·g, Σ u²
        for (size_t p = 0; p < poses.size(); ++p) {
            DPL_RETURN_IF_ERROR(look());
            const auto adds = contributions(ungated, cloth, poses[p], views[p], jobs);
            for (size_t v = 0; v < adds.size(); ++v)
                for (size_t i = 0; i < count; ++i) {
                    const double u = adds[v][i];
                    both[i] += u * gatedAdds[p][v][i], own[i] += u * u;
                }
        }
        for (size_t i = 0; i < count; ++i) {
            if (!(avatar.splats.flags[i] & kSplatSingleFace) || !(own[i] > 0)) continue;
            const float best = float(std::min(1.0, both[i] / own[i]));
            if (best < kWhole) factor[i] *= best;
            ungated.splats.opacity[i] = avatar.splats.opacity[i] * factor[i];
        }
    }
    return factor;
}

Result<AvatarData> withoutGate(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs) {
    DPL_TRY(const std::vector<float> factor, opacityWithoutGate(avatar, poses, jobs));
    const SplatData& from = avatar.splats;
    const size_t shFloats = from.count() == 0 ? 0 : from.sh.size() / from.count();
    AvatarData out = avatar;
    SplatData& to = out.splats = {};
    to.shDegree = from.shDegree, to.triangleStart = {0};
    for (size_t t = 0; t + 1 < from.triangleStart.size(); ++t) {
        for (uint32_t i = from.triangleStart[t]; i < from.triangleStart[t + 1]; ++i) {
            const float opacity = from.opacity[i] * factor[i];
            if (factor[i] < 1 && opacity < float(kMinAlpha)) continue;
            to.uv.push_back(from.uv[i]), to.phi.push_back(from.phi[i]), to.scaleM.push_back(from.scaleM[i]);
            to.opacity.push_back(opacity), to.flags.push_back(from.flags[i]);
            to.sh.insert(to.sh.end(), from.sh.begin() + std::ptrdiff_t(i * shFloats), from.sh.begin() + std::ptrdiff_t((i + 1) * shFloats));
        }
        to.triangleStart.push_back(to.count());
    }
    return out;
}

}  // namespace dpl
