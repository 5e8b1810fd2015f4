// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/overlays.h"

#include <gtest/gtest.h>

#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;

class OverlaysTest : public ::testing::Test {
protected:
    ViewedSubject avatar() {
        AvatarData data = test::tinyAvatar();
        data.mesh.jointIndices[2] = data.mesh.jointIndices[3] = glm::u16vec4(1, 0, 0, 0);  // the upper edge goes with the shoulder
        sortSplats(data);
        auto avatar = context_->loadAvatar(must(writeAvatar(data)));
        EXPECT_TRUE(avatar) << avatar.error().message;
        ViewedSubject made = must(ViewedSubject::of(std::move(*avatar), "tiny.glb"));
        made.clip.reset();
        return made;
    }
    doppel::Result<doppel::Context> context_ = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
};

TEST(StretchOf, isThatOfThePlane) {
    const std::array<Vec3f, 3> rest{Vec3f(0, 0, 0), Vec3f(2, 0, 0), Vec3f(1, 1, 0)};
    const auto expect = [&](const Mat3f& map, float most, float least) {
        const Stretch stretch = stretchOf(rest, {map * rest[0], map * rest[1], map * rest[2]});
        EXPECT_NEAR(stretch.most, most, 1e-5f);
        EXPECT_NEAR(stretch.least, least, 1e-5f);
    };
    expect(Mat3f(1), 1, 1);
    expect(Mat3f(0, 1, 0, 0, 0, 1, 1, 0, 0), 1, 1);                  // turned out of its plane
    expect(Mat3f(3, 0, 0, 0, 0.25f, 0, 0, 0, 1), 3, 0.25f);          // a needle
    expect(Mat3f(1, 0, 0, 1, 1, 0, 0, 0, 1), 1.618034f, 0.618034f);  // sheared by 1
    expect(Mat3f(1, 0, 0, 0, 0, 0, 0, 0, 1), 1, 0);                  // folded onto a line
    const Stretch none = stretchOf({rest[0], rest[1], rest[1]}, rest);
    EXPECT_EQ(none.most, 1);
    EXPECT_EQ(none.least, 1);
}

TEST_F(OverlaysTest, nothingIsStretchedAtRestAndSomethingIsWhereAJointTears) {
    ViewedSubject subject = avatar();
    OverlayMaker maker;
    ASSERT_TRUE(subject.pose({}, 0));
    OverlayShapes shapes = must(maker.shapes(subject, Overlay::Needles, {}, 0));
    EXPECT_TRUE(shapes.triangles.empty()) << shapes.words;
    subject.byHandDeg[1] = {0, 0, 170};
    ASSERT_TRUE(subject.pose({}, 0));
    shapes = must(maker.shapes(subject, Overlay::Needles, {}, 0));
    ASSERT_FALSE(shapes.triangles.empty()) << shapes.words;
    subject.asideM = 5;
    ASSERT_TRUE(subject.pose({}, 0));
    const OverlayShapes aside = must(maker.shapes(subject, Overlay::Needles, {}, 0));
    ASSERT_EQ(aside.triangles.size(), shapes.triangles.size());
    EXPECT_NEAR(aside.triangles[0].corners[1].x, shapes.triangles[0].corners[1].x + 5, 1e-4f) << "they lie in the world";
}

TEST_F(OverlaysTest, lookingChangesNoPose) {
    ViewedSubject subject = avatar();
    subject.byHandDeg[1] = {20, 30, 40};
    ASSERT_TRUE(subject.pose({}, 0));
    std::vector<float> before(8), after(8);
    float root[3];
    ASSERT_EQ(dplGetPose(subject.avatar.handle(), before.data(), 2, root), DPL_OK);
    OverlayMaker maker;
    ASSERT_TRUE(maker.shapes(subject, Overlay::Needles, {}, 0));
    ASSERT_EQ(dplGetPose(subject.avatar.handle(), after.data(), 2, root), DPL_OK);
    EXPECT_EQ(before, after);
}

TEST_F(OverlaysTest, saysWhatAFileDoesNotTell) {
    ViewedSubject subject = avatar();
    OverlayMaker maker;
    const OverlayShapes shapes = must(maker.shapes(subject, Overlay::Trust, {}, 0));
    EXPECT_TRUE(shapes.joints.empty());
    EXPECT_NE(shapes.words, "");
    EXPECT_EQ(must(maker.shapes(subject, Overlay::None, {}, 0)).words, "");
}

}  // namespace
