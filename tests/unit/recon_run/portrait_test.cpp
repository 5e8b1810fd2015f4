// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/portrait.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

class PortraitTest : public testing::Test {
protected:
    PortraitTest() {
        std::swap(toy_.metric.cameras[0], toy_.metric.cameras[kFront]);  // the first camera stands before the front (+Z)
        for (size_t f = 0; f < ToyReconstruction::kFrames; ++f)
            poses_.frames.push_back({toy_.table.scan.frames[f].name, toy_.table.scan.frames[f].kind, toy_.table.scan.frames[f].split,
                                     toy_.truth[f], std::nullopt});
    }
    static constexpr size_t kFront = 2;
    Portrait draw() {
        AvatarView view = must(AvatarView::open(toy_.package.bytes, 2));
        return must(drawPortrait(toy_.table.scan, toy_.metric.cameras, poses_, toy_.avatar, view, toy_.jobs));
    }
    static Picture decoded(const Portrait& portrait) { return must(decodePicture(portrait.png, PictureChannels::Rgb)); }
    /** Mean of the pixels' darkness in a quarter of the picture, by the halves that it lies in. */
    static double inkIn(const Picture& p, bool right, bool low) {
        double sum = 0;
        for (uint32_t y = low ? p.heightPx / 2 : 0; y < (low ? p.heightPx : p.heightPx / 2); ++y)
            for (uint32_t x = right ? p.widthPx / 2 : 0; x < (right ? p.widthPx : p.widthPx / 2); ++x)
                sum += 255 - p.pixels[(size_t(y) * p.widthPx + x) * 3];
        return sum;
    }

    ToyReconstruction toy_;
    PosesFile poses_;
};

TEST_F(PortraitTest, showsTheFrontWholeAndOnWhite) {
    const Portrait portrait = draw();
    EXPECT_EQ(portrait.frame, "frame_2");
    const Picture picture = decoded(portrait);
    EXPECT_EQ(std::max(picture.widthPx, picture.heightPx), 960u);
    size_t inked = 0, edge = 0;
    for (uint32_t y = 0; y < picture.heightPx; ++y)
        for (uint32_t x = 0; x < picture.widthPx; ++x) {
            const bool ink = picture.pixels[(size_t(y) * picture.widthPx + x) * 3] < 250;
            inked += ink;
            edge += ink && (x == 0 || y == 0 || x + 1 == picture.widthPx || y + 1 == picture.heightPx);
        }
    EXPECT_GT(double(inked), 0.4 * picture.widthPx * picture.heightPx) << "the ball fills its picture";
    EXPECT_EQ(edge, 0u) << "nothing is cut";
}

TEST_F(PortraitTest, isUprightHoweverThePhoneWasHeld) {
    const Picture upright = decoded(draw());
    Camerad& camera = toy_.metric.cameras[kFront];  // turned by a quarter: what was right is down
    const Mat3d quarter(Vec3d(0, 1, 0), Vec3d(-1, 0, 0), Vec3d(0, 0, 1));
    camera.viewFromWorldRotation = quarter * camera.viewFromWorldRotation;
    camera.viewFromWorldTranslation = quarter * camera.viewFromWorldTranslation;
    const Portrait portrait = draw();
    EXPECT_EQ(portrait.frame, "frame_2");
    const Picture turned = decoded(portrait);
    ASSERT_EQ(turned.widthPx, upright.widthPx);
    ASSERT_EQ(turned.heightPx, upright.heightPx);
    for (const bool right : {false, true})
        for (const bool low : {false, true}) EXPECT_NEAR(inkIn(turned, right, low) / inkIn(upright, right, low), 1, 0.01);
}

TEST_F(PortraitTest, stillFramesComeFirstThenMovingOnesThenCloseUps) {
    for (size_t f = 0; f < ToyReconstruction::kFrames; ++f)
        toy_.table.scan.frames[f].kind = f == kFront ? FrameKind::StaticCloseup : f == 4 ? FrameKind::StaticFull : FrameKind::Dynamic;
    EXPECT_EQ(draw().frame, "frame_4") << "although it shows the side";
    toy_.table.scan.frames[4].kind = FrameKind::StaticCloseup;
    const std::string moving = draw().frame;
    EXPECT_NE(moving, "frame_2");
    EXPECT_NE(moving, "frame_4");
}

TEST_F(PortraitTest, camerasThatDoNotSeeThePersonDrawNothing) {
    toy_.metric.cameras[kFront].viewFromWorldTranslation.z = -5;  // the person is behind it
    EXPECT_NE(draw().frame, "frame_2");
    for (Camerad& camera : toy_.metric.cameras) camera.viewFromWorldTranslation.z = -5;
    EXPECT_TRUE(draw().png.empty());
}

}  // namespace
}  // namespace dpl::test
