// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/portrait.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/score.h"
#include "sdk/avatar/posed_mesh.h"

namespace dpl {
namespace {

constexpr double kHeightPx = 960;  // sharp on a phone, which shows it about 380 points high at up to 3 pixels a point
constexpr double kMaxWidthPx = 960;
constexpr double kSmallHeightPx = 240;
constexpr int kJpegQuality = 85;
constexpr double kMargin = 0.04;   // of the longer side, beyond the mesh, whose splats reach past it
constexpr double kNearestM = 0.1;  // a vertex nearer than this, or behind the camera, has no useful place in the picture

/** Cosine between where the trunk faces (+Z at rest) and where the eye is. */
double facing(std::span<const JointData> joints, const Pose& pose, const Camerad& camera) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(joints, pose, worldFromRest);
    const double cosine =
        glm::dot(glm::normalize(Vec3d(worldFromRest[0][2])), glm::normalize(camera.eye() - Vec3d(rootPosition(joints, pose))));
    return std::isfinite(cosine) ? cosine : -1;
}

/** The camera in quarter turns about its axis until `up` points upwards: a phone may have been held sideways. Its middle is lost. */
Camerad upright(Camerad camera, const Vec3d& up) {
    const Mat3d quarter(Vec3d(0, 1, 0), Vec3d(-1, 0, 0), Vec3d(0, 0, 1));
    Vec3d seen = camera.viewFromWorldRotation * up;
    for (int turn = 0; turn < 3 && !(-seen.y >= std::abs(seen.x)); ++turn) {
        seen = quarter * seen;
        camera.viewFromWorldRotation = quarter * camera.viewFromWorldRotation;
        camera.viewFromWorldTranslation = quarter * camera.viewFromWorldTranslation;
        std::swap(camera.fx, camera.fy);
    }
    return camera;
}

/** The camera with a picture that holds all `positions` and no more; nothing when one is not before it. */
std::optional<Camerad> framed(Camerad camera, std::span<const Vec3f> positions) {
    Vec2d low(1e30), high(-1e30);
    camera.cx = camera.cy = 0;
    for (const Vec3f& p : positions) {
        const Vec3d seen = camera.toView(Vec3d(p));
        if (!(seen.z > kNearestM)) return std::nullopt;
        low = glm::min(low, camera.pixelOf(seen)), high = glm::max(high, camera.pixelOf(seen));
    }
    const double margin = kMargin * std::max(high.x - low.x, high.y - low.y);
    low -= Vec2d(margin), high += Vec2d(margin);
    const Vec2d size = high - low;
    const double factor = std::min(kHeightPx / size.y, kMaxWidthPx / size.x);
    if (!std::isfinite(factor)) return std::nullopt;
    camera.cx = -factor * low.x, camera.cy = -factor * low.y;
    camera.fx *= factor, camera.fy *= factor;
    camera.widthPx = uint32_t(std::max(1.0, std::round(factor * size.x)));
    camera.heightPx = uint32_t(std::max(1.0, std::round(factor * size.y)));
    return camera;
}

}  // namespace

Result<Portrait> drawPortrait(const Scan& scan, std::span<const Camerad> cameras, const PosesFile& poses, const AvatarData& avatar,
                              AvatarView& view, Jobs& jobs) {
    std::vector<std::pair<double, size_t>> order;  // best first
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        const FrameKind kind = scan.frames[f].kind;
        const double worse = kind == FrameKind::StaticFull ? 0 : kind == FrameKind::Dynamic ? 10 : 20;
        order.emplace_back(worse - facing(avatar.joints, poses.frames[f].bestPose(), cameras[f]), f);
    }
    std::sort(order.begin(), order.end());
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    PosedMesh posed;
    for (const auto& [worse, f] : order) {
        const Pose& pose = poses.frames[f].bestPose();
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, pose, jobs);
        const std::optional<Camerad> camera = framed(upright(cameras[f], Vec3d(posed.worldFromRest()[0][1])), posed.positions());
        if (!camera) continue;
        DPL_TRY(const auto rgba, view.draw(pose, *camera));
        DPL_TRY(auto png, encodePng(overWhite(rgba), camera->widthPx, camera->heightPx, 3));
        const Camerad small = camera->scaled(std::min(1.0, kSmallHeightPx / camera->heightPx));
        DPL_TRY(auto jpeg, encodeJpeg(overWhite(areaAveraged(rgba, camera->widthPx, camera->heightPx, small.widthPx, small.heightPx)),
                                      small.widthPx, small.heightPx, 3, kJpegQuality));
        return Portrait{std::move(png), std::move(jpeg), scan.frames[f].name};
    }
    return Portrait{};
}

}  // namespace dpl
