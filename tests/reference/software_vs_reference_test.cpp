// The software renderer against the referee on random meshes, splats, poses and views.
#include "tests/reference/compare_renderers.h"
#include "tests/reference/random_avatar.h"

namespace dpl {
namespace {

// The product's bar is 50 dB. Measured: 120 dB and more, 93 dB where one pixel falls on the other side of the 1/255 cut-off; a
// renderer that loses a row of pixels at tile edges measured 60 to 82 dB, so the bar stands between.
constexpr double kBarDb = 88;

TEST(SoftwareVsReference, randomAvatarsPosesAndViews) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const AvatarData avatar = randomAvatar(seed, 8, 4, seed % 4);
        const Pose pose = randomPose(avatar, seed);
        const Vec3f eye(1.7f * std::sin(float(seed)), 1 + 0.3f * float(seed % 3), 1.7f * std::cos(float(seed)));
        const Cameraf camera = lookAt(eye, {0, 1, 0}, 150 + 7 * seed, 200 - 9 * seed, 180);
        const ReferenceScene scene = sceneOf(avatar, pose);
        const ReferenceImage reference = renderReference(scene, referenceCamera(camera));
        ASSERT_GT(coverage(reference.alpha), 0.1);
        expectSameImage(("avatar " + std::to_string(seed)).c_str(), drawSoftware(scene, camera), reference, kBarDb);
    }
}

TEST(SoftwareVsReference, randomStaticSplatsOfEveryShDegree) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        const StaticSplatData splats = randomStaticSplats(degree + 1, 1500, degree);
        const Cameraf camera = lookAt({0.7f, 0.4f, -2.f}, {0, 0, 0}, 211, 173, 200);
        const ReferenceImage reference = renderReference(splats, referenceCamera(camera));
        ASSERT_GT(coverage(reference.alpha), 0.1);
        expectSameImage(("static, SH " + std::to_string(degree)).c_str(), drawSoftware(splats, camera), reference, kBarDb);
    }
}

TEST(SoftwareVsReference, sameBytesOnAnyThreadCount) {
    const AvatarData avatar = randomAvatar(3, 40, 4);
    const ReferenceScene scene = sceneOf(avatar, randomPose(avatar, 3));
    const Cameraf camera = lookAt({1, 1.2f, 1}, {0, 1, 0}, 250, 190, 200);
    const SplatImage one = drawSoftware(scene, camera, 1);
    EXPECT_GT(coverage(one.alpha), 0.1);
    for (uint32_t threads = 2; threads <= 3; ++threads) {
        const SplatImage many = drawSoftware(scene, camera, threads);
        EXPECT_EQ(one.rgb, many.rgb);
        EXPECT_EQ(one.alpha, many.alpha);
        EXPECT_EQ(one.cloth, many.cloth);
        EXPECT_EQ(one.depthM, many.depthM);
    }
}

}  // namespace
}  // namespace dpl
