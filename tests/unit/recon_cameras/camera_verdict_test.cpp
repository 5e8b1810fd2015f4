// SPDX-License-Identifier: Apache-2.0
// The verdict says which part to film again, and why.
#include "reconstruction/input/cameras/camera_verdict.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

struct Walk {
    std::vector<SolvePicture> pictures;
    SolvedCameras solved;

    /** A walk of 24 stills that begins at the front (+Z) and goes to the subject's left (+X) first, with a close-up and a moving picture.
     */
    Walk() {
        const auto cameras = orbit(24);
        const auto add = [&](const std::string& name, SolveRole role, const Camerad& camera) {
            pictures.push_back({name, name + ".jpg", role});
            solved.pictures.push_back({camera, 900, 500, 300, 0.4, false});
        };
        for (size_t i = 0; i < 24; ++i) add("full_" + std::to_string(i), SolveRole::Still, cameras[i]);
        add("close_0", SolveRole::Closeup, cameras[0]);
        add("dyn_0", SolveRole::Moving, cameras[1]);
        solved.missPx = 0.4;
    }
    void lose(size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) solved.pictures[i].camera.reset();
    }
    CameraVerdict judge(const Vec3d& front = {0, 0, 1}) const { return judgeCameras(pictures, solved, {0, 1, 0}, front); }
};

bool says(const CameraVerdict& verdict, const std::string& part) {
    for (const std::string& sentence : verdict.sentences)
        if (sentence.find(part) != std::string::npos) return true;
    return false;
}

TEST(CameraVerdict, allPlacedIsOneSentence) {
    const CameraVerdict verdict = Walk().judge();
    EXPECT_FALSE(verdict.refuses);
    ASSERT_EQ(verdict.sentences.size(), 1u);
    EXPECT_TRUE(says(verdict, "24 of 24 still pictures, 1 of 1 close-ups, 1 of 1 moving and 0 of 0 held-out pictures"))
        << verdict.sentences[0];
    EXPECT_TRUE(says(verdict, "focal length 380 px")) << verdict.sentences[0];
}

TEST(CameraVerdict, gapIsNamedByItsSide) {
    const std::pair<size_t, const char*> gaps[] = {{5, "the left side"}, {11, "the back"}, {17, "the right side"}};
    for (const auto& [at, side] : gaps) {
        Walk walk;
        walk.lose(at, at + 3);
        const CameraVerdict verdict = walk.judge();
        EXPECT_FALSE(verdict.refuses);
        EXPECT_TRUE(says(verdict, "3 pictures from full_" + std::to_string(at) + " to full_" + std::to_string(at + 2))) << at;
        EXPECT_TRUE(says(verdict, std::string("film ") + side + " again, slower")) << verdict.sentences.back();
    }
    Walk walk;
    walk.lose(5, 6);
    EXPECT_TRUE(says(walk.judge(Vec3d(0)), "picture full_5 is left out: too few matches with their neighbours; film that part again"));
}

TEST(CameraVerdict, blurAndTextureAreToldApart) {
    Walk blurred;
    blurred.lose(5, 8);
    for (size_t i = 5; i < 8; ++i) blurred.solved.pictures[i].sharpness = 40;
    EXPECT_TRUE(says(blurred.judge(), "too blurred"));
    EXPECT_FALSE(says(blurred.judge(), "texture"));
    Walk bare;
    bare.lose(0, 20);
    for (auto& picture : bare.solved.pictures) picture.features = 60;
    EXPECT_TRUE(says(bare.judge(), "too little texture"));
    EXPECT_TRUE(bare.judge().refuses);
}

TEST(CameraVerdict, tooFewStillsRefuse) {
    Walk walk;
    walk.lose(11, 24);
    EXPECT_TRUE(walk.judge().refuses) << "11 of 24";
    Walk none;
    none.lose(0, 26);
    EXPECT_TRUE(none.judge().refuses);
    EXPECT_TRUE(says(none.judge(), "0 of 24 still pictures"));
    EXPECT_FALSE(says(none.judge(), "focal length")) << "no camera, no focal length";
    EXPECT_TRUE(judgeCameras({}, {}, {0, 1, 0}, {0, 0, 1}).refuses);
}

TEST(CameraVerdict, closeupsAreAskedForWithBackground) {
    Walk walk;
    walk.lose(24, 25);
    EXPECT_TRUE(
        says(walk.judge(), "picture close_0 is left out: too few matches with the walk; film the close-up again with some background"));
}

}  // namespace
}  // namespace dpl
