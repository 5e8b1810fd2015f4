// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/frame_table.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl {
namespace {

TEST(FrameTable, aHeldOutFrameWithoutAMaskIsNotScored) {
    test::ToyReconstruction toy;
    FrameTable& table = toy.table;
    for (const size_t f : {5, 6, 7}) table.scan.frames[f].maskPath.clear();
    const std::vector<Camerad> cameras(table.rows(), table.scan.frames[0].camera);
    const std::vector<Pose> poses(table.rows(), Pose::rest(2));
    EXPECT_TRUE(table.frames(Split::Test, cameras, poses).frames.empty());
}

TEST(FrameTable, framesOfASplitHoldNoPicture) {
    test::ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    toy.table.pictures = std::make_shared<PictureCache>(0);
    const FrameSet set = toy.table.frames(Split::Train, toy.metric.cameras, toy.truth);
    ASSERT_EQ(set.frames.size(), test::ToyReconstruction::kTrained);
    std::vector<std::weak_ptr<const FramePicture>> seen;
    for (const TrainFrame& frame : set.frames) {
        const auto picture = frame.picture.get();
        ASSERT_TRUE(picture) << picture.error().message;
        EXPECT_EQ((*picture)->image.pixels, must(readFramePicture(toy.table.scan.frames[set.rows[seen.size()]])).image.pixels);
        seen.push_back(*picture);
    }
    for (const auto& picture : seen) EXPECT_TRUE(picture.expired()) << "only whoever works on it holds a picture";
}

TEST(PictureCache, threadsThatAskTogetherGetOnePicture) {
    test::ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    PictureCache cache;
    Jobs jobs(4);
    std::vector<std::shared_ptr<const FramePicture>> got(64);
    jobs.forBlocks(got.size(), [&](size_t i, uint32_t) { got[i] = must(cache.of(toy.table.scan.frames[i % 2])); });
    for (size_t i = 2; i < got.size(); ++i) EXPECT_EQ(got[i], got[i - 2]);
}

TEST(PictureCache, keepsPicturesWithinItsBound) {
    test::ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    const uint64_t one = uint64_t(test::ToyReconstruction::kSizePx) * test::ToyReconstruction::kSizePx * 4;  // RGB and mask
    PictureCache cache(3 * one);
    std::vector<std::weak_ptr<const FramePicture>> seen;
    for (const ScanFrame& frame : toy.table.scan.frames) {
        const auto picture = cache.of(frame);
        ASSERT_TRUE(picture) << picture.error().message;
        seen.push_back(*picture);
        EXPECT_LE(cache.keptBytes(), 3 * one);
        size_t alive = 0;
        for (const auto& each : seen) alive += !each.expired();
        EXPECT_LE(alive, 3u);
    }
    EXPECT_EQ(cache.keptBytes(), 3 * one) << "the bound is used";
    EXPECT_FALSE(seen.back().expired());
    EXPECT_TRUE(seen.front().expired());
}

TEST(PictureCache, aPictureThatSomebodyHoldsIsDecodedOnce) {
    test::ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    PictureCache cache(0);
    const ScanFrame& frame = toy.table.scan.frames[0];
    const auto held = cache.of(frame);
    ASSERT_TRUE(held);
    EXPECT_EQ(cache.keptBytes(), 0u);
    std::filesystem::remove(frame.imagePath);
    const auto again = cache.of(frame);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(*again, *held);
}

}  // namespace
}  // namespace dpl
