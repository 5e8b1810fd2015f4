// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/register_frames.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/registration/priors.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/recon_registration/painted_scene.h"

namespace dpl::test {
namespace {

bool finite(const Pose& pose) {
    return std::isfinite(glm::length(pose.rootTranslation)) && std::all_of(pose.localRotations.begin(), pose.localRotations.end(),
                                                                           [](const Quatf& q) { return std::isfinite(glm::dot(q, q)); });
}

TEST(RegisterFrames, picturesImproveOnKeypoints) {
    PaintedScene scene(8);
    const auto with = scene.registered();
    ASSERT_TRUE(with) << with.error().message;
    for (RegisterFrame& frame : scene.frames)
        if (frame.kind == FrameKind::Dynamic) frame.picture = {};
    const auto without = scene.registered();
    ASSERT_TRUE(without) << without.error().message;
    const double pictures = scene.errorMm(with->poses, FrameKind::Dynamic), keypoints = scene.errorMm(without->poses, FrameKind::Dynamic);
    std::printf("mean keypoint error: start %.1f mm, keypoints %.1f mm, pictures %.1f mm; still %.1f mm\n",
                scene.errorMm(scene.starts(), FrameKind::Dynamic), keypoints, pictures, scene.errorMm(with->poses, FrameKind::StaticFull));
    EXPECT_LT(pictures, 0.9 * keypoints);
    EXPECT_LT(scene.errorMm(with->poses, FrameKind::StaticFull), 6);  // half a pixel
}

TEST(RegisterFrames, pictureWeightGuardsAgainstKeypointsThatErrAlike) {
    PaintedScene scene(8);
    for (size_t f = 0; f < scene.frames.size(); ++f)
        if (scene.frames[f].kind == FrameKind::Dynamic)
            for (Keypoint& k : scene.keypoints[f]) k.px += Vec2d(4, -2);
    const auto errorMm = [&](double weight) {
        RegisterInput input = scene.input();
        input.pictureWeight = weight;
        const auto result = registerFrames(input, {}, scene.jobs);
        EXPECT_TRUE(result) << result.error().message;
        return result ? scene.errorMm(result->poses, FrameKind::Dynamic) : 0.0;
    };
    const double usual = errorMm(1), more = errorMm(priors::kFoundPictureWeight);
    std::printf("mean keypoint error: weight 1: %.1f mm, weight %.0f: %.1f mm\n", usual, priors::kFoundPictureWeight, more);
    EXPECT_GT(usual, 12) << "the case is not hard";
    EXPECT_LT(more, 0.8 * usual);
}

TEST(RegisterFrames, resultsDoNotDependOnThreads) {
    PaintedScene scene(4);
    RegisterSettings quick;
    quick.blursPx = {2}, quick.roundsPerBlur = 1;
    Jobs one(1), three(3);
    const auto a = registerFrames(scene.input(), quick, one), b = registerFrames(scene.input(), quick, three);
    ASSERT_TRUE(a && b);
    for (size_t f = 0; f < a->poses.size(); ++f) {
        EXPECT_EQ(a->poses[f].localRotations, b->poses[f].localRotations) << f;
        EXPECT_EQ(a->poses[f].rootTranslation, b->poses[f].rootTranslation) << f;
        EXPECT_EQ(a->precisions[f].matrix, b->precisions[f].matrix) << f;
    }
}

TEST(RegisterFrames, precisionsSayHowWellPosesAreKnown) {
    PaintedScene scene(6);
    RegisterSettings quick;
    quick.blursPx = {2}, quick.roundsPerBlur = 1;
    scene.frames[2].split = Split::Test, scene.frames[2].picture = {};  // a still frame that is not solved
    const auto a = scene.registered(quick);
    ASSERT_TRUE(a) << a.error().message;
    ASSERT_EQ(a->precisions.size(), scene.frames.size());
    for (const PosePrecision& p : a->precisions) {
        const size_t n = p.size();
        ASSERT_EQ(p.matrix.size(), n * n);
        EXPECT_EQ(p.joints.front(), 0u);
        for (size_t i = 0; i < n; ++i) {
            EXPECT_GT(p.matrix[i * n + i], 0) << i;
            for (size_t j = 0; j < i; ++j) EXPECT_EQ(p.matrix[i * n + j], p.matrix[j * n + i]);
        }
    }
    const size_t n = a->precisions[2].size(), at = n - 3;
    EXPECT_NEAR(a->precisions[2].matrix[at * n + at] * priors::kSwayM * priors::kSwayM, 1, 1e-9) << "not solved: the sway's prior";
    EXPECT_NEAR(a->precisions[2].matrix[0] * priors::kSwayTurnRad * priors::kSwayTurnRad, 1, 0.01);
    EXPECT_GT(a->precisions[3].matrix[at * n + at], 1.5 / (priors::kSwayM * priors::kSwayM)) << "its picture tells more";
    RegisterInput weighed = scene.input();
    weighed.pictureWeight = 3;
    const auto third = registerFrames(weighed, quick, scene.jobs);
    ASSERT_TRUE(third) << third.error().message;
    EXPECT_NEAR(third->precisions[2].matrix[at * n + at] * priors::kSwayM * priors::kSwayM, 1.0 / 3, 1e-9) << "pictures count once";
    // Without keypoints less is known.
    for (Keypoint& k : scene.keypoints[3]) k.confidence = 0;
    const auto b = scene.registered(quick);
    ASSERT_TRUE(b) << b.error().message;
    EXPECT_LT(b->precisions[3].matrix[at * n + at], 0.9 * a->precisions[3].matrix[at * n + at]);
}

TEST(RegisterFrames, heldOutFramesReachNoOther) {
    PaintedScene scene(6);
    RegisterSettings quick;
    quick.blursPx = {2}, quick.roundsPerBlur = 1;
    RegisterFrame& held = scene.frames[15];
    held.split = Split::Test;
    scene.frames[14].split = Split::Validation;  // it does not depend on a test frame either
    scene.frames[14].picture = {};
    EXPECT_FALSE(scene.registered(quick)) << "its picture must not even be given";
    held.picture = {};
    const auto a = scene.registered(quick);
    ASSERT_TRUE(a) << a.error().message;
    for (Keypoint& k : scene.keypoints[15]) k.px = {20, 30};
    held.pose.rootTranslation.x += 0.3f;
    const auto b = scene.registered(quick);
    ASSERT_TRUE(b) << b.error().message;
    for (size_t f = 0; f < a->poses.size(); ++f) {
        if (f == 15) continue;
        EXPECT_EQ(a->poses[f].localRotations, b->poses[f].localRotations) << f;
        EXPECT_EQ(a->poses[f].rootTranslation, b->poses[f].rootTranslation) << f;
    }
    EXPECT_NE(a->poses[15].rootTranslation, b->poses[15].rootTranslation) << "the change was read";
}

/** A thigh that swings forwards starts as one that swings backwards: from the front both look much alike. Least squares stay there. */
TEST(RegisterFrames, searchFindsTheOtherDepthOfALimb) {
    PaintedScene scene(4, true, 7, 0.8);
    const size_t hip = size_t(findHumanoid(scene.body, "rightUpperLeg"));
    for (RegisterFrame& frame : scene.frames)
        if (frame.kind == FrameKind::Dynamic) frame.pose.localRotations[hip] = glm::conjugate(frame.pose.localRotations[hip]);
    RegisterSettings quick;
    quick.blursPx = {2, 1};
    const auto registered = [&](bool search) {
        RegisterInput input = scene.input();
        input.searchLimbs = search;
        return registerFrames(input, quick, scene.jobs);
    };
    const auto without = registered(false), with = registered(true);
    ASSERT_TRUE(without && with);
    /** Mean over moving frames of the distance of the foot. */
    const auto footMm = [&](const std::vector<Pose>& poses) {
        const size_t foot = size_t(std::find(scene.names.begin(), scene.names.end(), "ankle_r") - scene.names.begin());
        double sum = 0, count = 0;
        for (size_t f = 0; f < poses.size(); ++f)
            if (scene.frames[f].kind == FrameKind::Dynamic)
                sum += 1000 * glm::length(posedKeypoints(scene.body, poses[f], scene.names)[foot].place -
                                          posedKeypoints(scene.body, scene.truth[f], scene.names)[foot].place),
                    ++count;
        return sum / count;
    };
    const double stays = footMm(without->poses), found = footMm(with->poses);
    std::printf("mean error of the foot: start %.1f mm, without search %.1f mm, with it %.1f mm\n", footMm(scene.starts()), stays, found);
    EXPECT_GT(stays, 30) << "the case is not hard";
    EXPECT_LT(found, 12);
}

TEST(RegisterFrames, searchNeedsNoPicture) {
    PaintedScene scene(4, true, 7, 0.8);
    RegisterInput input = scene.input();
    input.searchLimbs = true;
    for (RegisterFrame& frame : input.frames) frame.picture = {};
    for (Keypoint& k : scene.keypoints.back()) k.px += Vec2d(8, 0);  // doubted
    input.frames.back().split = Split::Test;
    const auto result = registerFrames(input, {}, scene.jobs);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_TRUE(std::all_of(result->poses.begin(), result->poses.end(), finite));
    EXPECT_TRUE(std::any_of(result->solves.begin(), result->solves.end(),
                            [](const SolveEnd& solve) { return solve.what == "limbs at another depth"; }));
}

TEST(RegisterFrames, searchTellsItsProgressAndCanBeStopped) {
    PaintedScene scene(4, true, 7, 0.8);
    RegisterInput input = scene.input();
    input.searchLimbs = true;
    RegisterSettings settings;
    settings.blursPx = {4, 2, 1}, settings.roundsPerBlur = 1;
    constexpr const char* kSearch = "limbs at other depths";
    test::HeardTask whole;
    {
        const TaskScope scope(&whole);
        ASSERT_TRUE(registerFrames(input, settings, scene.jobs));
    }
    double last = 0;
    size_t before = 0;  // the search
    for (const auto& [share, doing] : whole.heard) {
        EXPECT_GE(share, last) << doing;
        last = share;
    }
    EXPECT_LE(last, 1);
    while (before < whole.heard.size() && whole.heard[before].second != kSearch) ++before;
    ASSERT_LT(before, whole.heard.size());
    test::HeardTask stopping(before + 1);
    const TaskScope scope(&stopping);
    const auto stopped = registerFrames(input, settings, scene.jobs);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::Cancelled);
}

TEST(RegisterFrames, hardCases) {
    RegisterSettings quick;
    quick.blursPx = {2}, quick.roundsPerBlur = 2;
    const auto check = [&](PaintedScene& scene, const char* what, double atMostMm) {
        const auto result = scene.registered(quick);
        ASSERT_TRUE(result) << what << ": " << result.error().message;
        for (const Pose& pose : result->poses) EXPECT_TRUE(finite(pose)) << what;
        const double mm = scene.errorMm(result->poses, FrameKind::Dynamic);
        std::printf("%-28s %.1f mm, start %.1f mm\n", what, mm, scene.errorMm(scene.starts(), FrameKind::Dynamic));
        EXPECT_LT(mm, atMostMm) << what;
    };
    PaintedScene one(1), same(4, /*moves=*/false), empty(5), none(5), wrong(5);
    check(one, "one moving frame", 22);
    check(same, "all frames in one pose", 22);
    for (size_t f = 12; f < empty.pictures.size(); ++f)
        std::fill(empty.pictures[f]->mask.pixels.begin(), empty.pictures[f]->mask.pixels.end(), 0);
    check(empty, "empty masks", 25);
    none.frames[14].keypoints = {};
    check(none, "a frame without keypoints", 22);
    for (size_t k = 0; k < wrong.keypoints[14].size(); k += 3) wrong.keypoints[14][k].px += Vec2d(60, -40);
    check(wrong, "a third of a frame's keypoints are wrong", 25);
    PaintedScene bare(3);
    for (RegisterFrame& frame : bare.frames) frame.picture = {}, frame.keypoints = {};
    const auto untouched = bare.registered(quick);
    ASSERT_TRUE(untouched) << untouched.error().message;
    for (const Pose& pose : untouched->poses) EXPECT_TRUE(finite(pose));
}

TEST(RegisterFrames, refusesSizesThatDoNotMatch) {
    PaintedScene scene(2);
    RegisterInput input = scene.input();
    input.rigidTriangle = std::span(scene.rigid).first(3);
    EXPECT_FALSE(registerFrames(input, {}, scene.jobs));
    input = scene.input();
    input.frames[13].keypoints = input.frames[13].keypoints.first(4);
    EXPECT_FALSE(registerFrames(input, {}, scene.jobs));
    input = scene.input();
    input.frames[13].camera.widthPx /= 2;
    EXPECT_FALSE(registerFrames(input, {}, scene.jobs));
}

TEST(RegisterFrames, largePicturesAreReduced) {
    PaintedScene scene(1);
    const FramePicture small = *scene.pictures[0];
    FramePicture large;
    const uint32_t times = 4;
    large.image = {small.image.widthPx * times, small.image.heightPx * times, {}};
    large.mask = {small.mask.widthPx * times, small.mask.heightPx * times, {}};
    for (uint32_t y = 0; y < large.mask.heightPx; ++y)
        for (uint32_t x = 0; x < large.mask.widthPx; ++x) {
            const size_t from = size_t(y / times) * small.mask.widthPx + x / times;
            large.mask.pixels.push_back(small.mask.pixels[from]);
            for (size_t a = 0; a < 3; ++a) large.image.pixels.push_back(small.image.pixels[3 * from + a]);
        }
    RegisterSettings quick;
    quick.blursPx = {2}, quick.roundsPerBlur = 1;
    *scene.pictures[0] = large;
    scene.frames[0].camera = scene.frames[0].camera.scaled(times);
    for (Keypoint& k : scene.keypoints[0]) k.px *= double(times);
    const auto result = scene.registered(quick);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_LT(scene.errorMm(result->poses, FrameKind::StaticFull), 8);
}

}  // namespace
}  // namespace dpl::test
