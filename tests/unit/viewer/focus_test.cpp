// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/focus.h"

#include <gtest/gtest.h>

#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"

namespace {

using namespace dpl;

class FocusTest : public ::testing::Test {
protected:
    ViewedSubject load(const AvatarData& data) {
        auto avatar = context_->loadAvatar(*writeAvatar(data));
        EXPECT_TRUE(avatar) << avatar.error().message;
        auto subject = ViewedSubject::of(std::move(*avatar), "tiny.glb");
        EXPECT_TRUE(subject && subject->pose({}, 0));
        return std::move(*subject);
    }
    /** A board, 1 m square, that faces +Z, with joints called as those of a head and a hand. */
    static AvatarData board() {
        AvatarData data = test::tinyAvatar();
        data.clips.clear();
        data.joints = {{"pelvis", -1, {0, 0.5f, 0}, "hips"},
                       {"neck", 0, {0, 1.3f, 0}, "neck"},
                       {"head", 1, {0, 1.4f, 0}, "head"},
                       {"forearm", 0, {0.2f, 1, 0}, "leftLowerArm"},
                       {"wrist", 3, {0.4f, 1, 0}, "leftHand"}};
        sortSplats(data);
        return data;
    }
    doppel::Result<doppel::Context> context_ = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
};

Vec3d middleOf(const WorldBox& box) {
    return 0.5 * (box.low + box.high);
}

TEST_F(FocusTest, theFaceLiesAboveTheHeadsJointAndThePalmBeyondTheWrist) {
    ViewedSubject subject = load(board());
    subject.asideM = 3;
    ASSERT_TRUE(subject.pose({}, 0));
    const auto face = boxOfPart(subject, SeenPart::Face), hand = boxOfPart(subject, SeenPart::LeftHand);
    ASSERT_TRUE(face && hand);
    EXPECT_NEAR(middleOf(*face).x, 3, 1e-5);
    EXPECT_GT(middleOf(*face).y, 1.44);
    EXPECT_LT(middleOf(*face).y, 1.5);
    EXPECT_GT(middleOf(*hand).x, 3.42);
    EXPECT_LT(middleOf(*hand).x, 3.5);
    EXPECT_LT(face->high.y - face->low.y, 0.4);
    EXPECT_FALSE(boxOfPart(subject, SeenPart::RightHand)) << "there is no such joint";
    EXPECT_EQ(boxOfPart(subject, SeenPart::Whole)->high.y, subject.box().high.y);
}

TEST_F(FocusTest, picksTheNearestAvatarThatIsShown) {
    std::vector<ViewedSubject> subjects;
    subjects.push_back(load(board()));
    subjects.push_back(load(board()));
    subjects[1].asideM = 1;
    ASSERT_TRUE(subjects[1].pose({}, 0));
    OrbitCamera orbit;
    orbit.frame(boxOf(subjects), 1);
    const Camerad camera = orbit.camera(400, 400, 200);
    const auto at = [&](const Vec3d& world) { return placeAt(subjects, camera, camera.pixelOf(camera.toView(world))); };
    const auto first = at({-0.2, 1, 0}), second = at({1.2, 0.7, 0});
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->subject, 0u);
    EXPECT_EQ(second->subject, 1u);
    EXPECT_LT(glm::length(second->point - Vec3d(1.2, 0.7, 0)), 1e-3);
    EXPECT_FALSE(at({0, 2.2, 0}));
    subjects[0].shown = false;
    EXPECT_FALSE(at({-0.2, 1, 0}));
    EXPECT_EQ(at({1.2, 0.7, 0})->subject, 1u) << "counted among all, hidden ones too";
    EXPECT_FALSE(placeAt({}, camera, {200, 200}));
}

}  // namespace
