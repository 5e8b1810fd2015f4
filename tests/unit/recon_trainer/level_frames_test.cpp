// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/level_frames.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

class LevelFramesTest : public testing::Test {
protected:
    LevelFramesTest() {
        for (uint32_t i = 0; i < frames_.size(); ++i) used_.push_back(i);
    }
    LevelFrames levels(uint64_t boundBytes) { return LevelFrames(frames_, {}, boundBytes, jobs_); }
    /** Bytes of all frames at full size. */
    uint64_t allBytes() {
        LevelFrames all = levels(~0ull);
        EXPECT_TRUE(all.select(1, 1, used_));
        return all.keptBytes();
    }

    Jobs jobs_{2};
    PictureCounts counts_;
    const std::vector<TrainFrame> frames_ = decodedOnDemand(toyScene(jobs_).frames, counts_);
    std::vector<uint32_t> used_;
};

TEST_F(LevelFramesTest, keepsFramesWithinItsBoundAndHoldsNoPicture) {
    const uint64_t bound = allBytes() / 2;
    LevelFrames half = levels(bound);
    for (const int level : {0, 1}) {
        ASSERT_TRUE(half.select(level, 1, used_));
        EXPECT_LE(half.keptBytes(), bound);
        for (const uint32_t frame : used_) {
            ASSERT_TRUE(half.at(frame));
            EXPECT_LE(half.keptBytes(), bound);
            EXPECT_EQ(counts_.alive, 0);
        }
    }
    EXPECT_GT(half.keptBytes(), bound / 2) << "the bound is used";
    EXPECT_LE(counts_.mostAlive, int(jobs_.threadCount()));
}

TEST_F(LevelFramesTest, aFrameBeyondTheBoundIsMadeAgainAndTheSame) {
    LevelFrames all = levels(~0ull), none = levels(0);
    ASSERT_TRUE(all.select(0, 1, used_));
    ASSERT_TRUE(none.select(0, 1, used_));
    const int before = counts_.decoded;
    for (const uint32_t frame : used_) {
        const LevelFrame &kept = **all.at(frame), &made = **none.at(frame);
        EXPECT_EQ(made.rgb, kept.rgb);
        EXPECT_EQ(made.mask, kept.mask);
        EXPECT_EQ(made.camera.fx, kept.camera.fx);
        EXPECT_EQ(made.personPx, kept.personPx);
        EXPECT_EQ(*none.at(frame), &made) << "it is still there";
    }
    EXPECT_EQ(counts_.decoded, before + int(used_.size())) << "once for each frame that is not kept";
    EXPECT_EQ(none.keptBytes(), 0u);
}

TEST_F(LevelFramesTest, aPictureThatIsGoneIsAnError) {
    std::vector<TrainFrame> frames = frames_;
    frames[1].picture = LazyPicture([]() -> Result<std::shared_ptr<const FramePicture>> { return fail(Code::Io, "toy_1.png is gone"); });
    LevelFrames broken(frames, {}, ~0ull, jobs_);
    const Status all = broken.select(0, 1, used_);
    ASSERT_FALSE(all);
    EXPECT_EQ(all.error().message, "toy_1.png is gone");
}

}  // namespace
}  // namespace dpl::test
