// SPDX-License-Identifier: Apache-2.0
// The model of the bytes that a frame reads and writes, on frames counted by hand.
#include "tools/bench/frames/frame_model.h"

#include <gtest/gtest.h>

#include "shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/shared/frame.h"

namespace dpl {
namespace {

const ModelledPass& passOf(const std::vector<ModelledPass>& passes, const std::string& label) {
    for (const ModelledPass& pass : passes)
        if (pass.label == label) return pass;
    ADD_FAILURE() << "no pass " << label;
    return passes.front();
}

uint64_t sum(const std::vector<ModelledPass>& passes) {
    uint64_t bytes = 0;
    for (const ModelledPass& pass : passes) bytes += pass.bytes();
    return bytes;
}

/** 10,000 splats of SH degree 1 on 2,000 triangles, a fifth of them drawn. */
FrameWork known() {
    return {.vertices = 1000,
            .triangles = 2000,
            .splats = 10000,
            .shDegree = 1,
            .views = 1,
            .pixels = 100 * 100,
            .trianglesFacing = 500,
            .groups = 79,
            .liveGroups = 20,
            .splatsDrawn = 2000,
            .bytesDecided = 30000,
            .bytesDecoded = 40000};
}

TEST(FrameModel, thePlainFrameIsWhatOneCountsByHand) {
    const auto passes = modelPlainFloat(known());
    EXPECT_EQ(passOf(passes, "pose.skin").readBytes, 1000u * 32);
    EXPECT_EQ(passOf(passes, "pose.skin").writtenBytes, 1000u * 16);
    EXPECT_EQ(passOf(passes, "pose.triangles").readBytes, 2000u * 64 + 1000u * 16);
    EXPECT_EQ(passOf(passes, "pose.triangles").writtenBytes, 2000u * 128);
    const ModelledPass& project = passOf(passes, "chunks, splat.project and splat.colour");
    EXPECT_EQ(project.readBytes, 10000u * 32 + 2000u * 80 + 10000u * 4 + 2000u * (32 + 4 * 3 * 4) + 2000u * 128);
    EXPECT_EQ(project.writtenBytes, 10000u * (48 + 4) + 2000u * 12);
    EXPECT_EQ(passOf(passes, "compact").readBytes, 2u * 10000 * 4);
    EXPECT_EQ(passOf(passes, "compact").writtenBytes, 2000u * 8);
    EXPECT_EQ(passOf(passes, "sort").readBytes, 8u * (2 * 2000 * 8 + 2 * 16 * 4)) << "2,000 pairs are one block of sixteen digits";
    EXPECT_EQ(passOf(passes, "sort").writtenBytes, 8u * (2000 * 8 + 3 * 16 * 4));
    EXPECT_EQ(passOf(passes, "pixels").readBytes, 2000u * (8 + 48));
    EXPECT_EQ(passOf(passes, "pixels").writtenBytes, 10000u * 8);
}

TEST(FrameModel, todaysFrameReadsCodesAndWritesSurvivors) {
    using namespace gpu;
    const auto passes = modelToday(known());
    const ModelledPass& project = passOf(passes, "chunks, splat.project and splat.colour");
    EXPECT_EQ(project.readBytes, 30000u + 40000u + 2000u * 16 + 500u * sizeof(TriangleFrame) + 2 * 79u * 4);
    EXPECT_EQ(project.writtenBytes, 3 * 79u * 4 + 2000u * sizeof(ProjectedSplat) + (20u * kSplatGroup - 2000u) * 4 + 20u * kSplatGroup * 4);
    const uint64_t runs = (2000 + kRun - 1) / kRun;
    EXPECT_EQ(passOf(passes, "sort").bytes(), 2000u * (2 * 8 + 4 + 2 * 4 + 4) + kSortRounds * 5 * kSortDigits * runs * 4)
        << "pairs in the first round, words from there";
    EXPECT_EQ(passOf(passes, "pixels").writtenBytes, 10000u * 8);
    EXPECT_LT(sum(passes), sum(modelPlainFloat(known())));
}

TEST(FrameModel, culledSplatsCostTodayNothingAndThePlainFrameAll) {
    FrameWork work = known(), twice = work;
    twice.splats *= 2;  // the added splats are in chunks that no view shows
    EXPECT_EQ(sum(modelToday(work)), sum(modelToday(twice)));
    EXPECT_GT(sum(modelPlainFloat(twice)), sum(modelPlainFloat(work)));
}

TEST(FrameModel, twoViewsAreTwoPlainFramesButOneOfToday) {
    const FrameWork mono = known();
    FrameWork stereo = mono;
    stereo.views = 2, stereo.pixels *= 2;
    EXPECT_EQ(sum(modelPlainFloat(stereo)), 2 * sum(modelPlainFloat(mono)));
    EXPECT_LT(sum(modelToday(stereo)), 2 * sum(modelToday(mono)));
    EXPECT_EQ(passOf(modelToday(stereo), "sort").bytes(), passOf(modelToday(mono), "sort").bytes());
    EXPECT_EQ(passOf(modelToday(stereo), "pose.triangles").bytes(), passOf(modelToday(mono), "pose.triangles").bytes());
}

TEST(FrameModel, tilesReadARecordAnEntryAndWriteBytes) {
    FrameWork work = known();
    work.tileEntries = 9000;
    const auto passes = modelToday(work);
    EXPECT_EQ(passOf(passes, "pixels").readBytes, 9000u * (4 + 32));
    EXPECT_EQ(passOf(passes, "pixels").writtenBytes, 2 * 10000u * 4);
    EXPECT_EQ(passOf(passes, "tile lists").writtenBytes, 9000u * 4);
}

TEST(FrameModel, workFollowsWhatIsLeftOfEachTier) {
    FrameWork work = known();
    work.splatsFacing = 2500, work.tileEntries = 9000;
    const auto ops = [](const FrameWork& w, const char* label) { return passOf(modelToday(w), label).operations; };
    FrameWork more = work;
    more.splatsFacing *= 2;
    EXPECT_GT(ops(more, "chunks, splat.project and splat.colour"), ops(work, "chunks, splat.project and splat.colour"));
    more = work, more.tileEntries *= 3;
    EXPECT_EQ(ops(more, "pixels"), 3 * ops(work, "pixels"));
    more = work, more.splats *= 2;
    EXPECT_EQ(ops(more, "chunks, splat.project and splat.colour"), ops(work, "chunks, splat.project and splat.colour"))
        << "what is culled is no work";
    EXPECT_GT(passOf(modelPlainFloat(more), "chunks, splat.project and splat.colour").operations,
              passOf(modelPlainFloat(work), "chunks, splat.project and splat.colour").operations);
    more = work, more.shDegree = 3;
    EXPECT_GT(ops(more, "chunks, splat.project and splat.colour"), ops(work, "chunks, splat.project and splat.colour"));
    EXPECT_GT(ops(work, "pose.skin"), 100u * work.vertices);
}

TEST(FrameModel, correctivesMakeSkinningReadMore) {
    FrameWork work = known();
    work.corrected = true;
    EXPECT_EQ(passOf(modelToday(work), "pose.skin").readBytes, 1000u * 48);
    EXPECT_EQ(passOf(modelPlainFloat(work), "pose.skin").readBytes, 1000u * 48);
}

TEST(FrameModel, lightMakesSkinningWorkMoreAndReadNoMore) {
    FrameWork lit = known();
    lit.lit = true;
    const ModelledPass with = passOf(modelToday(lit), "pose.skin"), without = passOf(modelToday(known()), "pose.skin");
    EXPECT_GT(with.operations, 2 * without.operations);
    EXPECT_EQ(with.bytes(), without.bytes());
    EXPECT_EQ(passOf(modelPlainFloat(lit), "pose.skin").operations, without.operations) << "the frozen frame knows no light";
}

TEST(FrameModel, aPassTakesAsLongAsTheSlowerOfMovingAndWorking) {
    const ModelledPass pass{"x", 30'000'000, 20'000'000, 4'000'000};
    EXPECT_DOUBLE_EQ(pass.milliseconds({50, 4}), 1.0);
    EXPECT_DOUBLE_EQ(pass.milliseconds({50, 1}), 4.0);
    const std::string rows = modelRows("case", {{"sort", 1'000'000, 500'000, 600'000}, {"pixels", 0, 0, 3'000'000}},
                                       {{"sort", 500'000, 250'000}, {"tile lists", 1, 1}, {"pixels", 0, 0}}, {1.5, 1});
    EXPECT_NE(rows.find("| case | sort | 1.00 + 0.50 | 0.6 | 1.000 | 0.50 + 0.25 | 0.0 | 0.500 |"), std::string::npos) << rows;
    EXPECT_NE(rows.find("| case | tile lists | – | – | – |"), std::string::npos) << rows;
    EXPECT_LT(rows.find("tile lists"), rows.find("pixels"));
    EXPECT_NE(rows.find("| case | sum | 1.00 + 0.50 | 3.6 | 4.000 |"), std::string::npos) << rows << "1 ms of moving, then 3 of working";
}

}  // namespace
}  // namespace dpl
