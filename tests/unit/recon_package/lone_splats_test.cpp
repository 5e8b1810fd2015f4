// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/lone_splats.h"

#include <gtest/gtest.h>

#include "reconstruction/output/package/avatar_drawer.h"
#include "tests/unit/ball_mesh.h"

namespace dpl::test {
namespace {

constexpr uint32_t kSizePx = 96;

/** A ball under splats, and beside it a small triangle whose one splat stands free in every view. */
struct Ball {
    AvatarData avatar;
    std::vector<TrainFrame> frames;
    uint32_t planted = 0;  // index of the lone splat
    Jobs jobs{2};

    explicit Ball(FrameKind kind = FrameKind::StaticFull) {
        avatar.joints.resize(2);
        avatar.joints[0].name = "root", avatar.joints[1].name = "top", avatar.joints[1].parent = 0;
        avatar.kappaPx2 = 1.0f / 12;
        avatar.mesh = ballMesh(20, 28);
        MeshData& m = avatar.mesh;
        const uint32_t first = uint32_t(m.restPositions.size());
        for (const Vec3f& p : {Vec3f(0, 0.3f, 0), Vec3f(0.01f, 0.3f, 0), Vec3f(0, 0.31f, 0)}) {
            m.restPositions.push_back(p);
            m.jointIndices.push_back({0, 0, 0, 0}), m.jointWeights.push_back({255, 0, 0, 0});
        }
        m.triangles.insert(m.triangles.begin() + 5, Triangle(first, first + 1, first + 2));
        planted = 5;
        SplatData& s = avatar.splats;
        for (uint32_t t = 0; t < m.triangles.size(); ++t) {
            s.triangleStart.push_back(t);
            s.uv.push_back({1.0f / 3, 1.0f / 3}), s.phi.push_back(0), s.flags.push_back(0);
            s.scaleM.push_back(t == planted ? Vec2f(0.008f) : Vec2f(0.015f)), s.opacity.push_back(0.9f);
            for (int c = 0; c < 3; ++c) s.sh.push_back(float(t % 7) / 7);
        }
        s.triangleStart.push_back(s.count());
        AvatarData clean = avatar;
        clean.splats.opacity[planted] = 0;
        AvatarDrawer drawer(clean, jobs);
        SplatImage image;
        for (uint32_t k = 0; k < 4; ++k) {
            TrainFrame f;
            f.name = "ball_" + std::to_string(k), f.kind = kind, f.pose = Pose::rest(2);
            const double a = 1.5707963 * k;
            f.camera.widthPx = f.camera.heightPx = kSizePx;
            f.camera.fx = f.camera.fy = 1.1 * kSizePx, f.camera.cx = f.camera.cy = 0.5 * kSizePx;
            f.camera.viewFromWorldRotation = Mat3d(std::cos(a), 0, -std::sin(a), 0, -1, 0, -std::sin(a), 0, -std::cos(a));
            f.camera.viewFromWorldTranslation = {0, 0, 0.9};
            drawer.project(f.pose, f.camera.cast<float>()).blend(image);
            FramePicture picture{{kSizePx, kSizePx, std::vector<uint8_t>(3 * image.alpha.size())}, {kSizePx, kSizePx, {}}, {}};
            for (const float alpha : image.alpha) picture.mask.pixels.push_back(alpha >= 0.5f ? 255 : 0);
            f.picture = std::make_shared<const FramePicture>(std::move(picture));
            frames.push_back(std::move(f));
        }
    }
};

TEST(LoneSplats, aPlantedSpeckGoesAndTheBallStays) {
    Ball ball;
    const SplatData before = ball.avatar.splats;
    EXPECT_EQ(*dropLoneSplats(ball.avatar, ball.frames, ball.jobs), 1u);
    const SplatData& after = ball.avatar.splats;
    ASSERT_EQ(after.count(), before.count() - 1);
    ASSERT_EQ(after.triangleStart.size(), before.triangleStart.size());
    EXPECT_EQ(after.triangleStart.back(), after.count());
    EXPECT_EQ(after.triangleStart[ball.planted], after.triangleStart[ball.planted + 1]) << "its triangle is bare";
    for (uint32_t i = 0; i < after.count(); ++i) {
        const uint32_t was = i < ball.planted ? i : i + 1;
        ASSERT_EQ(after.scaleM[i], before.scaleM[was]);
        for (uint32_t c = 0; c < 3; ++c) ASSERT_EQ(after.sh[3 * i + c], before.sh[3 * was + c]);
    }
    EXPECT_EQ(*dropLoneSplats(ball.avatar, ball.frames, ball.jobs), 0u) << "nothing is left to take";
}

TEST(LoneSplats, whatTheMaskShowsStays) {
    Ball ball;
    AvatarDrawer drawer(ball.avatar, ball.jobs);
    SplatImage image;
    for (TrainFrame& frame : ball.frames) {
        FramePicture picture = **frame.picture.get();
        drawer.project(frame.pose, frame.camera.cast<float>()).blend(image);
        for (size_t i = 0; i < image.alpha.size(); ++i) picture.mask.pixels[i] = image.alpha[i] >= 0.1f ? 255 : 0;
        frame.picture = std::make_shared<const FramePicture>(std::move(picture));
    }
    EXPECT_EQ(*dropLoneSplats(ball.avatar, ball.frames, ball.jobs), 0u);
}

TEST(LoneSplats, movingFramesDoNotCount) {
    Ball ball(FrameKind::Dynamic);
    EXPECT_EQ(*dropLoneSplats(ball.avatar, ball.frames, ball.jobs), 0u);
}

}  // namespace
}  // namespace dpl::test
