// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/run_news.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/run/stage_words.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/must.h"
#include "tests/unit/wait_until.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class RunNewsTest : public testing::Test {
protected:
    void SetUp() override { fs::create_directories(out_); }
    void TearDown() override { fs::remove_all(out_); }
    json told() const {
        const auto bytes = must(readFile(out_ / RunNews::kProgress));
        return json::parse(bytes.begin(), bytes.end());
    }
    /** Waits until progress.json is there and `holds` for it. */
    template <class Condition>
    bool comesTo(Condition holds) const {
        return waitUntil([&] { return fs::exists(out_ / RunNews::kProgress) && holds(told()); });
    }
    const fs::path out_ = fs::temp_directory_path() / ("doppel_news_" + std::to_string(::getpid()));
};

TEST_F(RunNewsTest, tellsTheStageItsShareAndItsEnd) {
    {
        RunNews news(out_);
        news.stage("co-optimise");
        news.doing(0.25, "step 500 of 2000");
        news.curve({{100, 18.25f, 0.5f}, {200, 20, NAN}}, 2000);
        ASSERT_TRUE(comesTo([](const json& now) { return now["share"] == 0.25; }));
        const json now = told();
        EXPECT_EQ(now["format"], "doppel-progress");
        EXPECT_EQ(now["state"], "running");
        EXPECT_EQ(now["stage"], "co-optimise");
        EXPECT_EQ(now["words"], "painting");
        EXPECT_EQ(now["place"], 7);
        EXPECT_EQ(now["detail"], "step 500 of 2000");
        EXPECT_EQ(now["steps"], 2000);
        EXPECT_EQ(now["curve"], (json{{100, 18.25, 0.5}, {200, 20.0, 0.0}}));
        EXPECT_TRUE(now["seconds_left"].is_null()) << "one look says nothing of the speed";
        const auto beat = now["beat"].get<uint64_t>();
        EXPECT_TRUE(comesTo([&](const json& later) { return later["beat"].get<uint64_t>() > beat; })) << "it beats without news";
        news.ended({});
    }
    EXPECT_EQ(told()["state"], "done");
    EXPECT_EQ(told()["sentence"], "");
}

TEST_F(RunNewsTest, saysHowItEnded) {
    RunNews(out_).ended(fail(Code::Cancelled, "cancelled"));
    EXPECT_EQ(told()["state"], "stopped");
    RunNews(out_).ended(fail(Code::Io, "no space left"));
    EXPECT_EQ(told()["state"], "failed");
    EXPECT_EQ(told()["sentence"], "no space left");
    { RunNews forgotten(out_); }
    EXPECT_EQ(told()["state"], "failed");
}

TEST_F(RunNewsTest, tellsTheTimeThatTheRunTakesOnceItIsMeasured) {
    RunNews news(out_);
    news.plan({3000, 200, 40, "report"});
    for (const char* stage : {"ingest", "body-fit", "surface", "body-map", "garments", "register"}) news.stage(stage), news.tookBefore(100);
    news.stage("co-optimise");
    ASSERT_TRUE(comesTo([](const json& now) { return !now["run_seconds_left"].is_null(); }));
    EXPECT_TRUE(told()["seconds_left"].is_null());
    // 600 s for what took 63 s: 9.5 times the 289.1 s of the stages to come, of which some seconds have passed.
    EXPECT_NEAR(told()["run_seconds_left"].get<double>(), 600 / 63.0 * 289.1, 0.05 * 2750);
    news.ended({});
    EXPECT_TRUE(comesTo([](const json& now) { return now["state"] == "done" && now["run_seconds_left"].is_null(); }));
}

TEST_F(RunNewsTest, aRunWhoseProcessEndsBeforeItTellsThatItWasStopped) {
    RunNews::sayStopped();  // no run tells: nothing happens
    RunNews news(out_);
    news.stage("evidence");
    news.avatar(randomAvatar(3, 16, 8, 1), 700, 0);
    ASSERT_TRUE(comesTo([](const json& now) { return !now["avatar"].is_null(); }));
    RunNews::sayStopped();  // the stage has not heard of it
    ASSERT_TRUE(comesTo([](const json& now) { return now["state"] == "stopped"; }));
    EXPECT_TRUE(told()["avatar"].is_null());
    news.stage("package"), news.ended({});
    EXPECT_EQ(told()["state"], "stopped") << "that was the last word";
}

TEST_F(RunNewsTest, showsAnAvatarAndThenWaits) {
    {
        RunNews news(out_);
        ASSERT_TRUE(news.wantsAvatar());
        news.avatar(randomAvatar(3, 16, 8, 1), 700, 0);
        EXPECT_FALSE(news.wantsAvatar());
        ASSERT_TRUE(comesTo([](const json& now) { return !now["avatar"].is_null(); }));
        EXPECT_EQ(told()["avatar"], (json{{"file", "watch/avatar.glb"}, {"step", 700}, {"change", 1}}));
        EXPECT_TRUE(readAvatar(must(readFile(out_ / RunNews::kAvatar))));
        EXPECT_FALSE(news.wantsAvatar()) << "ten seconds have not passed";
    }
    EXPECT_FALSE(fs::exists(out_ / RunNews::kFolder)) << "after the run nobody needs it";
    EXPECT_TRUE(told()["avatar"].is_null());
}

TEST_F(RunNewsTest, showsAHeldBackPictureMadeSmall) {
    RunNews news(out_);
    Picture picture{901, 1500, 3, {}};
    picture.pixels.assign(size_t(picture.widthPx) * picture.heightPx * 3, 90);
    news.heldBack("dyn_003", picture);
    ASSERT_TRUE(comesTo([](const json& now) { return !now["held_back"].is_null(); }));
    EXPECT_EQ(told()["held_back"], (json{{"frame", "dyn_003"}, {"picture", "watch/held-back.jpg"}}));
    const Picture shown = must(decodePicture(must(readFile(out_ / RunNews::kHeldBack)), PictureChannels::Rgb));
    EXPECT_EQ(shown.widthPx, 300u);
    EXPECT_EQ(shown.heightPx, 500u);
    EXPECT_NEAR(shown.pixels[3 * 1234], 90, 2);
}

TEST_F(RunNewsTest, whatCannotBeWrittenStopsNothing) {
    fs::remove_all(out_);
    std::ofstream(out_) << "a file where the folder was";
    RunNews news(out_);
    news.stage("ingest");
    news.avatar(randomAvatar(3, 16, 8, 1), 1, 0);
    EXPECT_TRUE(waitUntil([&] { return !news.wantsAvatar(); }));
    news.ended({});
}

TEST_F(RunNewsTest, keepsFilesOfOthers) {
    fs::create_directories(out_ / "watch");
    std::ofstream(out_ / "watch" / "notes.txt") << "mine";
    std::ofstream(out_ / "watch" / "avatar.glb.part77") << "of a run that was killed";
    RunNews(out_).ended({});
    EXPECT_TRUE(fs::exists(out_ / "watch" / "notes.txt"));
    EXPECT_FALSE(fs::exists(out_ / "watch" / "avatar.glb.part77"));
}

TEST(StageWords, countTheStagesThatEveryRunHas) {
    EXPECT_EQ(placeOfStage("ingest"), 1u);
    EXPECT_EQ(placeOfStage("report"), kStagesOfAll);
    EXPECT_EQ(placeOfStage("cameras"), 0u);
    EXPECT_EQ(placeOfStage(""), 0u);
}

}  // namespace
}  // namespace dpl::test
