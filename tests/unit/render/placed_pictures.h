// SPDX-License-Identifier: Apache-2.0
// Pictures of placed subjects, on any renderer. A placement moves the subject, so the picture is that of a camera moved the other way, or
// of a subject whose numbers were moved.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>

#include "sdk/draw/renderer.h"
#include "tests/reference/image_compare.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {

constexpr double kPlacedPsnrDb = 60;  // of every comparison here; what is left is rounding, and with it the order of equal depth keys
constexpr uint32_t kPlacedPx = 93;

inline Placement turnedPlacement(double scale) {
    return {glm::mat3_cast(glm::angleAxis(1.1, glm::normalize(Vec3d(0.3, 1, -0.2)))), scale, {3, -1, 2}};
}

/** The camera of the world that sees the placed subject as `own` sees it in its own space. */
inline Cameraf worldCamera(const Placement& p, const Cameraf& own) {
    const Mat3d turn = Mat3d(own.viewFromWorldRotation) * glm::transpose(p.rotation);
    const Vec3d ownEye = -(glm::transpose(Mat3d(own.viewFromWorldRotation)) * Vec3d(own.viewFromWorldTranslation));
    Cameraf world = own;
    world.viewFromWorldRotation = Mat3f(turn);
    world.viewFromWorldTranslation = Vec3f(-(turn * (p.rotation * (p.scale * ownEye) + p.translation)));
    return world;
}

inline std::vector<RenderedView> picturesOf(Renderer& r, std::span<const Drawn> what, std::span<const Cameraf> views, bool meshDepth) {
    FrameWants wants(true);
    wants.meshDepth = meshDepth;
    const Status drawn = r.drawTogether(what, views, wants);
    EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
    const auto read = r.read(what[0].avatar);
    EXPECT_TRUE(read) << (read ? "" : read.error().message);
    std::vector<RenderedView> out;
    for (const PixelView& p : drawn&& read ? *read : std::span<const PixelView>())
        out.push_back({p.widthPx,
                       p.heightPx,
                       {p.rgba.begin(), p.rgba.end()},
                       {p.depthM.begin(), p.depthM.end()},
                       {p.meshDepthM.begin(), p.meshDepthM.end()}});
    return out;
}

/** Expects the same pictures, with depths `scale` times as large in the first. */
inline void expectSamePictures(const char* what, const std::vector<RenderedView>& placed, const std::vector<RenderedView>& want,
                               double scale) {
    ASSERT_EQ(placed.size(), want.size());
    for (size_t v = 0; v < want.size(); ++v) {
        const auto codes = [](const RenderedView& view) {
            std::vector<double> out;
            for (const uint8_t code : view.rgba) out.push_back(code / 255.0);
            return out;
        };
        const ImageDifference d = compareImages(codes(placed[v]), codes(want[v]));
        size_t covered = 0, stray = 0;
        double mesh = 0;
        for (size_t i = 0; i < want[v].depthM.size(); ++i) {
            if (want[v].rgba[4 * i + 3] < 128) continue;
            ++covered;
            const double a = placed[v].depthM[i], b = want[v].depthM[i];
            stray += !(std::abs(a / scale - b) <= 0.005 * b);  // some devices sum depths in halves
        }
        for (size_t i = 0; i < want[v].meshDepthM.size(); ++i) {
            const double a = placed[v].meshDepthM[i], b = want[v].meshDepthM[i];
            if (a > 0 && b > 0) mesh = std::max(mesh, std::abs(a / scale - b));
            stray += (a > 0) != (b > 0);
        }
        std::printf("[  PLACED  ] %-28s scale %4.1f view %zu: %.1f dB (max %.0f codes), %zu pixels, %zu stray depths, mesh %.6f m\n", what,
                    scale, v, d.psnrDb, 255 * d.maxError, covered, stray, mesh);
        EXPECT_GE(d.psnrDb, kPlacedPsnrDb) << what;
        EXPECT_GT(covered, 300u) << what;
        EXPECT_LE(stray, covered / 100) << what << ": a splat at the 1/255 cut-off, or an edge of the mesh";
        EXPECT_LT(mesh, 1e-3) << what;
    }
}

/** Turned, scaled and moved: what the camera sees that is moved the other way. Two eyes; an avatar and general splats. */
inline void expectEqualToAMovedCamera(Renderer& r, bool withDetail = false) {
    AvatarData tube = codedOnce(makeTube({.splatsPerTriangle = 4, .shDegree = 3}));
    tube.trainedPixelM = 0.01f, tube.kappaPx2 = 1 / 12.0f;  // four samples a pixel, where the device has them
    const auto avatar = r.addAvatar(std::make_shared<const AvatarData>(std::move(tube)));
    const auto general = r.addSplats(randomStaticSplats(5, 400, 3));
    ASSERT_TRUE(avatar && general);
    const Pose pose = tubePose(0.7f, 0.4f);
    Cameraf own[2] = {tubeCamera(kPlacedPx, kPlacedPx, 0.6f, 4, -0.03f), tubeCamera(kPlacedPx, kPlacedPx, 0.6f, 4, 0.03f)};
    for (Cameraf& c : own) c.fx = c.fy = 1.6f * c.fx;
    if (withDetail) r.setDetail({0.3f, 0});
    for (const RenderAvatarId id : {*avatar, *general}) {
        const Drawn standing{id, &pose};
        const std::vector<RenderedView> want = picturesOf(r, {&standing, 1}, own, id == *avatar);
        for (const double scale : {0.1, 1.0, 10.0}) {
            const Drawn placed{id, &pose, turnedPlacement(scale)};
            const Cameraf views[2] = {worldCamera(placed.placement, own[0]), worldCamera(placed.placement, own[1])};
            expectSamePictures(id == *avatar ? "avatar" : "general splats", picturesOf(r, {&placed, 1}, views, id == *avatar), want, scale);
        }
    }
    r.setDetail({});
}

/** General splats whose numbers were multiplied are those that a placement scales: also where they fade before the near plane. */
inline void expectEqualToScaledNumbers(Renderer& r) {
    const StaticSplatData small = randomStaticSplats(5, 400, 3);
    const auto id = r.addSplats(small);
    ASSERT_TRUE(id);
    for (const double scale : {0.1, 10.0}) {
        StaticSplatData large = small;
        for (Vec3f& p : large.position) p *= float(scale);
        for (Vec3f& s : large.scaleM) s *= float(scale);
        const auto other = r.addSplats(large);
        ASSERT_TRUE(other);
        Cameraf view = tubeCamera(kPlacedPx, kPlacedPx, 0.6f, 2.5f);
        Vec3f nearest(0);
        float least = INFINITY;
        for (const Vec3f& p : large.position)
            if (const float z = view.toView(p).z; z < least) least = z, nearest = p;
        view.viewFromWorldTranslation -= view.toView(nearest) - Vec3f(0, 0, 0.1f);  // half faded
        const Pose none;
        const Drawn numbers{*other, &none}, placed{*id, &none, {Mat3d(1), scale, Vec3d(0)}};
        expectSamePictures("half faded", picturesOf(r, {&placed, 1}, {&view, 1}, false), picturesOf(r, {&numbers, 1}, {&view, 1}, false),
                           1);
        r.removeAvatar(*other);
    }
}

/** Two subjects with placements of their own that pierce each other: sorted by their depths in the world. */
inline void expectSortedInTheWorld(Renderer& r) {
    const auto tube = r.addAvatar(std::make_shared<const AvatarData>(codedOnce(makeTube({.splatsPerTriangle = 4, .shDegree = 1}))));
    const StaticSplatData cloud = randomStaticSplats(5, 400, 0);
    const Placement tubePlace = turnedPlacement(1.5);
    const Placement cloudPlace{glm::mat3_cast(glm::angleAxis(-0.8, glm::normalize(Vec3d(1, 0.2, 0.4)))), 0.8,
                               tubePlace.toWorld({0, 0.5, 0})};
    StaticSplatData baked = cloud;
    const Quatd turn = glm::quat_cast(cloudPlace.rotation);
    for (size_t i = 0; i < baked.position.size(); ++i) {
        baked.position[i] = Vec3f(cloudPlace.toWorld(Vec3d(cloud.position[i])));
        baked.rotation[i] = Quatf(turn * Quatd(cloud.rotation[i]));
        baked.scaleM[i] *= float(cloudPlace.scale);
    }
    const auto placedCloud = r.addSplats(cloud), bakedCloud = r.addSplats(baked);
    ASSERT_TRUE(tube && placedCloud && bakedCloud);
    const Pose pose = tubePose(0.4f);
    const Cameraf view = worldCamera(tubePlace, tubeCamera(kPlacedPx, kPlacedPx, 0.3f, 1.6f));
    const Drawn want[2] = {{*tube, &pose, tubePlace}, {*bakedCloud, &pose}},
                placed[2] = {{*tube, &pose, tubePlace}, {*placedCloud, &pose, cloudPlace}};
    expectSamePictures("together", picturesOf(r, placed, {&view, 1}, true), picturesOf(r, want, {&view, 1}, true), 1);
}

}  // namespace dpl
