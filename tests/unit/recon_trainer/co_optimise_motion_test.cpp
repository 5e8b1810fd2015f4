// SPDX-License-Identifier: Apache-2.0
// Motion modes in training: found again, untouched by still frames, and the same bytes however a run is cut.
#include <gtest/gtest.h>

#include <filesystem>

#include "sdk/format/motion_modes.h"
#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

/** toyCorrectives with one motion mode beside the bend: the ball has moved when it bends by more than 0.1 rad. */
PoseCorrectiveData movingCorrectives(const MeshData& mesh) {
    PoseCorrectiveData c = toyCorrectives(mesh);
    MotionModeData m;
    m.groups = {{.columnCount = 1}}, m.movedFromRad = 0.05f, m.movedToRad = 0.15f;
    m.joints = {1}, m.still = {{0, 0, 0, 1}}, m.rangeRad = {{0.05f, 0.5f}}, m.holdsS = {0}, m.modes = {1, 0};
    addMotionModes(c, std::move(m));
    return c;
}

/** The ball as a garment: motion modes move nothing else. */
CoOptimiseInput withClothes(CoOptimiseInput input) {
    input.mesh.layers = {{.name = "top",
                          .role = "garment",
                          .vertexCount = uint32_t(input.mesh.restPositions.size()),
                          .triangleCount = uint32_t(input.mesh.triangles.size())}};
    return input;
}

TEST(CoOptimiseMotion, motionModesAreFoundAgain) {
    Jobs jobs(2);
    PoseCorrectiveData truth = movingCorrectives(ballMesh());
    truth.nodes = {Vec4f(0), Vec4f(0, 0.02f, 0.01f, 0.3f), Vec4f(0), Vec4f(0.015f, 0, 0, -0.3f)};
    CoOptimiseInput input = withClothes(toyScene(jobs, 12, 0, 0, 72, truth));
    for (TrainFrame& still : toyScene(jobs, 12).frames) input.frames.push_back(std::move(still));  // at rest, where nothing is corrected
    input.correctives = movingCorrectives(input.mesh);
    CoOptimiseSettings settings = toySettings(960);
    settings.learnPoses = settings.learnGeometry = false;  // either could take the place of offsets
    settings.rateNodeOffset = 2e-3f;
    auto t = CoOptimiser::create(std::move(input), settings, jobs);
    ASSERT_TRUE(t) << t.error().message;
    ASSERT_TRUE((*t)->run());
    const CoOptimiseResult r = (*t)->result();
    for (const size_t n : {0u, 1u}) {
        const Vec4f found = r.correctives.nodes[2 * n + 1], want = truth.nodes[2 * n + 1];
        EXPECT_NEAR(found.w, want.w, 0.1) << "light of node " << n;
        for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a], want[a], 0.006) << "offset of node " << n;
    }
}

/** The same pose in every picture, in half of which the ball has moved before: only memory tells them apart. */
TEST(CoOptimiseMotion, whatClothesHoldIsFoundAgain) {
    Jobs jobs(2);
    PoseCorrectiveData truth = movingCorrectives(ballMesh());
    truth.motion.holdsS = {60};
    truth.nodes = {Vec4f(0), Vec4f(0, 0.02f, 0.01f, 0.3f), Vec4f(0), Vec4f(0.015f, 0, 0, -0.3f)};
    CoOptimiseInput input = withClothes(toyScene(jobs, 24, 0, 0, 72, truth, /*held=*/true));
    input.correctives = movingCorrectives(input.mesh);
    input.correctives.motion.holdsS = {60};
    CoOptimiseSettings settings = toySettings(960);
    settings.learnPoses = settings.learnGeometry = false;
    settings.rateNodeOffset = 2e-3f;
    auto t = CoOptimiser::create(std::move(input), settings, jobs);
    ASSERT_TRUE(t) << t.error().message;
    ASSERT_TRUE((*t)->run());
    const CoOptimiseResult r = (*t)->result();
    for (const size_t n : {0u, 1u}) {
        const Vec4f found = r.correctives.nodes[2 * n + 1], want = truth.nodes[2 * n + 1];
        EXPECT_NEAR(found.w, want.w, 0.1) << "light of node " << n;
        for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a], want[a], 0.006) << "offset of node " << n;
    }
}

TEST(CoOptimiseMotion, motionModesOfAFilmThatStandsStillLearnNothing) {
    Jobs jobs(2);
    CoOptimiseInput input = withClothes(toyScene(jobs, 8, 0.004f, 0));
    input.correctives = movingCorrectives(input.mesh);
    auto t = CoOptimiser::create(std::move(input), toySettings(24), jobs);
    ASSERT_TRUE(t && (*t)->run());
    const CoOptimiseResult r = (*t)->result();
    for (const size_t n : {0u, 1u}) EXPECT_EQ(r.correctives.nodes[2 * n + 1], Vec4f(0));
}

/** Moving pictures that look past the garment, as those of shoes below the edge: nothing tells how it moves, so it stays as it lies. */
TEST(CoOptimiseMotion, clothesThatStillFramesAloneShowKeepTheirShapeInMotion) {
    Jobs jobs(2);
    CoOptimiseInput input = withClothes(toyScene(jobs, 12));
    input.correctives = movingCorrectives(input.mesh);
    const Mat3d turnedAway(-1, 0, 0, 0, 1, 0, 0, 0, -1);
    size_t moving = 0;
    for (TrainFrame& frame : input.frames) {
        if (frame.kind != FrameKind::Dynamic) continue;
        ++moving;
        frame.pose.localRotations[1] = glm::angleAxis(0.4f, Vec3f(1, 0, 0));
        frame.camera.viewFromWorldRotation = turnedAway * frame.camera.viewFromWorldRotation;
        frame.camera.viewFromWorldTranslation = turnedAway * frame.camera.viewFromWorldTranslation;
        FramePicture empty = **frame.picture.get();
        std::fill(empty.image.pixels.begin(), empty.image.pixels.end(), uint8_t(77));
        std::fill(empty.mask.pixels.begin(), empty.mask.pixels.end(), uint8_t(0));
        frame.picture = std::make_shared<const FramePicture>(std::move(empty));
    }
    ASSERT_GE(moving, 3u);
    auto t = CoOptimiser::create(std::move(input), toySettings(120), jobs);
    ASSERT_TRUE(t) << t.error().message;
    const auto run = (*t)->run();
    ASSERT_TRUE(run) << run.error().message;
    const CoOptimiseResult r = (*t)->result();
    for (const size_t n : {0u, 1u}) EXPECT_EQ(r.correctives.nodes[2 * n + 1], Vec4f(0)) << "node " << n;
    const auto rest = ballMesh().restPositions;
    for (size_t v = 0; v < rest.size(); ++v) ASSERT_LT(glm::length(r.restPositions[v] - rest[v]), 0.02f) << "vertex " << v;
    EXPECT_GT(r.splats.sh.size(), 1000u);
}

TEST(CoOptimiseMotion, motionModesGiveTheSameBytesOnManyThreadsAndAfterRestore) {
    const auto path = std::filesystem::path(::testing::TempDir()) / "trainer_motion.checkpoint";
    const auto makeMoving = [&](Jobs& jobs) {
        CoOptimiseInput input = withClothes(toyScene(jobs, 8, 0.004f, 0.03f, 72, toyCorrectives(ballMesh())));
        input.correctives = movingCorrectives(input.mesh);
        return std::move(*CoOptimiser::create(std::move(input), toySettings(40), jobs));
    };
    Jobs one(1), three(3);
    auto whole = makeMoving(one), killed = makeMoving(three), rerun = makeMoving(three);
    ASSERT_TRUE(whole->run());
    EXPECT_NE(whole->result().correctives.nodes[1], Vec4f(0));
    ASSERT_TRUE(killed->run(23));
    ASSERT_TRUE(killed->checkpoint(path));
    const Status restored = rerun->restore(path);
    ASSERT_TRUE(restored) << restored.error().message;
    ASSERT_TRUE(rerun->run());
    const CoOptimiseResult a = rerun->result(), b = whole->result();
    EXPECT_TRUE(a.correctives.nodes == b.correctives.nodes);
    EXPECT_TRUE(a.restPositions == b.restPositions);
    EXPECT_TRUE(a.splats.sh == b.splats.sh && a.splats.uv == b.splats.uv);
    for (size_t f = 0; f < a.poses.size(); ++f) EXPECT_TRUE(a.poses[f].localRotations == b.poses[f].localRotations) << f;
}

}  // namespace
}  // namespace dpl::test
