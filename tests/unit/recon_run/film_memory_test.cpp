// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/film_memory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/run/carried_pose.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace {

using namespace dpl;

double meanAbsoluteLevels(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::abs(int(a[i]) - int(b[i]));
    return sum / double(a.size());
}

/** Joint 0, held for 6 s. */
MotionModeData holding() {
    MotionModeData m;
    m.groups = {{.columnCount = 1, .reach = 1}};
    m.joints = {0}, m.still = {{0, 0, 0, 1}}, m.rangeRad = {{0.1f, 2}}, m.movedFromRad = 0.1f, m.movedToRad = 0.2f;
    m.holdsS = {6}, m.modes = {1, 1};
    return m;
}

struct Film {
    Scan scan;
    PosesFile file;

    void add(FrameKind kind, double timeS, float angle) {
        Pose pose = Pose::rest(1);
        pose.localRotations[0] = glm::angleAxis(angle, Vec3f(1, 0, 0));
        scan.frames.emplace_back();
        scan.frames.back().kind = kind, scan.frames.back().timeS = timeS;
        file.frames.push_back({"frame", kind, Split::Train, pose, std::nullopt});
    }
    double heldAt(size_t frame) const { return file.frames[frame].pose.before.held[1]; }
};

TEST(FilmMemory, movingFramesRememberTheOnesBeforeThemAndStillFramesNothing) {
    Film film;
    film.add(FrameKind::Dynamic, 3, 0);  // frames of a scan need not be in the order of time
    film.add(FrameKind::StaticFull, 0, 1.1f);
    film.add(FrameKind::Dynamic, 1, 1.1f);
    film.add(FrameKind::Dynamic, 0.5, 0.3f);
    film.add(FrameKind::StaticCloseup, 0, 0);
    film.file.frames[0].fittedPose = film.file.frames[0].pose;
    film.file.frames[0].fittedPose->localRotations[0] = glm::angleAxis(0.7f, Vec3f(1, 0, 0));
    rememberPoses(film.scan, holding(), film.file);
    EXPECT_EQ(film.heldAt(3), 0) << "the first of the film";
    EXPECT_NEAR(film.heldAt(2), 0.2 * std::exp(-0.5 / 6), 1e-6);
    EXPECT_NEAR(film.heldAt(0), 1.0 * std::exp(-2 / 6.0), 1e-6);
    for (const size_t still : {1u, 4u}) EXPECT_EQ(film.file.frames[still].pose.before, MotionMemory());
    EXPECT_EQ(film.file.frames[0].fittedPose->before, film.file.frames[0].pose.before) << "the picture's own pose changes no memory";
}

TEST(FilmMemory, aFilmWithoutTimesOrAnAvatarWithoutMotionModesRemembersNothing) {
    Film film;
    for (const float angle : {1.1f, 0.0f, 0.5f}) film.add(FrameKind::Dynamic, 0, angle);
    rememberPoses(film.scan, holding(), film.file);
    for (const FramePose& frame : film.file.frames) EXPECT_EQ(frame.pose.before, MotionMemory());
    for (size_t f = 0; f < 3; ++f) film.scan.frames[f].timeS = double(f);
    rememberPoses(film.scan, MotionModeData(), film.file);
    for (const FramePose& frame : film.file.frames) EXPECT_EQ(frame.pose.before, MotionMemory());
}

TEST(FilmMemory, picturesOfOneMomentRememberTheSame) {
    Film film;
    film.add(FrameKind::Dynamic, 0, 1.1f);
    film.add(FrameKind::Dynamic, 2, 0);
    film.add(FrameKind::Dynamic, 2, 0);
    rememberPoses(film.scan, holding(), film.file);
    EXPECT_NEAR(film.heldAt(1), std::exp(-2 / 6.0), 1e-6);
    EXPECT_EQ(film.heldAt(2), film.heldAt(1));
}

TEST(FilmMemory, whatDecidesAboutAnAvatarDoesNotKnowThatHeldOutFramesCameBefore) {
    test::ToyReconstruction toy;
    MotionModeData motion = holding();
    motion.joints = {1};
    toy.table.scan.frames[7].timeS = 1, toy.table.scan.frames[3].timeS = 2, toy.table.scan.frames[4].timeS = 3;
    ASSERT_EQ(toy.table.scan.frames[7].split, Split::Test);
    const auto heldBefore = [&](size_t frame, HeldOut heldOut) {
        return posesAfterTraining(toy.table, toy.truth, toy.training.result, motion, heldOut)[frame].before.held[1];
    };
    EXPECT_GT(heldBefore(3, HeldOut::Known), 0.1);
    EXPECT_EQ(heldBefore(3, HeldOut::Unknown), 0) << "the first that is known";
    EXPECT_GT(heldBefore(4, HeldOut::Unknown), 0.1);
}

TEST(FilmMemory, picturesAreDrawnAndScoredWithWhatTheirPosesRemember) {
    test::ToyReconstruction toy;
    AvatarData& avatar = toy.avatar;
    avatar.correctives = test::ballCorrectives(avatar.mesh, {0, 0, 0, 0.2f}, {0, 0, 0, 0.2f});
    MotionModeData motion = holding();
    motion.joints = {1};
    addMotionModes(avatar.correctives, motion);
    for (uint32_t n = 0; n < avatar.correctives.nodeCount; ++n)
        avatar.correctives.nodes[n * avatar.correctives.columnCount() + avatar.correctives.modeCount] = Vec4f(0, 0.1f, 0, 0.5f);
    AvatarView view = must(AvatarView::open(test::bytesOf(avatar), 2));
    const Camerad& camera = toy.metric.cameras[0];
    const Pose still = Pose::rest(2);
    Pose after = still;
    after.before.held[0] = 1, after.before.held[1] = 0.8;
    const auto settled = must(view.draw(still, camera)), remembering = must(view.draw(after, camera));
    EXPECT_GT(meanAbsoluteLevels(settled, remembering), 3);
    EXPECT_TRUE(must(view.draw(still, camera)) == settled) << "and the next picture settles again";
}

}  // namespace
