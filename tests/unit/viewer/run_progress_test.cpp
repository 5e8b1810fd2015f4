// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_progress.h"

#include <gtest/gtest.h>

#include "reconstruction/base/time_words.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;

const std::string kGood = R"({"format":"doppel-progress","version":1,"state":"running","sentence":"","started_unix_s":1700000000,
"unix_s":1700000100,"beat":50,"seconds":100.5,"for_watchers_s":0.4,"stage":"co-optimise","words":"painting","detail":"step 300 of 2000",
"place":7,"places":11,"share":0.15,"seconds_left":700,"steps":2000,"curve":[[100,20.5,0.1],[200,22,0.05]],
"held_back":{"frame":"dyn_003","picture":"watch/held-back.jpg"},"avatar":{"file":"watch/avatar.glb","step":200,"change":3}})";

/** kGood with a part of it replaced. */
std::string with(const std::string& part, const std::string& other) {
    std::string text = kGood;
    const size_t at = text.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return text.replace(at, part.size(), other);
}

Result<RunProgress> parse(const std::string& text) {
    return parseRunProgress(text, "OUT/progress.json");
}

TEST(RunProgress, readsWhatARunWrites) {
    const RunProgress p = must(parse(kGood));
    EXPECT_EQ(p.state, RunProgress::State::Running);
    EXPECT_EQ(p.words, "painting");
    EXPECT_EQ(p.place, 7u);
    EXPECT_EQ(p.places, 11u);
    EXPECT_DOUBLE_EQ(p.share, 0.15);
    EXPECT_DOUBLE_EQ(p.secondsLeft.value(), 700);
    ASSERT_EQ(p.curve.size(), 2u);
    EXPECT_DOUBLE_EQ(p.curve[1].db, 22);
    EXPECT_EQ(p.heldBackFrame, "dyn_003");
    EXPECT_EQ(p.heldBackPicture, "watch/held-back.jpg");
    EXPECT_EQ(p.avatar, "watch/avatar.glb");
    EXPECT_DOUBLE_EQ(p.avatarChange, 3);
}

TEST(RunProgress, theFirstWordsOfARunHaveNoAvatarAndNoTimeLeft) {
    const RunProgress p = must(parse(R"({"format":"doppel-progress","version":1,"state":"running","seconds_left":null,"held_back":null,
        "avatar":null,"curve":[]})"));
    EXPECT_FALSE(p.secondsLeft);
    EXPECT_TRUE(p.avatar.empty() && p.heldBackPicture.empty() && p.curve.empty());
    EXPECT_EQ(p.place, 0u);
}

TEST(RunProgress, refusesEveryBeginningOfAFile) {
    for (size_t length = 0; length < kGood.size(); ++length) EXPECT_FALSE(parse(kGood.substr(0, length))) << length;
}

TEST(RunProgress, refusesWhatNoRunWrites) {
    for (const auto& [part, other] : {std::pair<std::string, std::string>{"doppel-progress", "doppel-run"},
                                      {"\"version\":1", "\"version\":2"},
                                      {"\"version\":1", "\"version\":\"1\""},
                                      {"\"running\"", "\"asleep\""},
                                      {"\"state\":\"running\",", ""},
                                      {"\"beat\":50", "\"beat\":1e999"},
                                      {"\"beat\":50", "\"beat\":-1"},
                                      {"\"beat\":50", "\"beat\":1e300"},
                                      {"\"beat\":50", "\"beat\":null"},
                                      {"\"share\":0.15", "\"share\":\"much\""},
                                      {"\"seconds_left\":700", "\"seconds_left\":-5"},
                                      {"\"words\":\"painting\"", "\"words\":[1]"},
                                      {"[100,20.5,0.1]", "[100]"},
                                      {"[100,20.5,0.1]", "{}"},
                                      {"[100,20.5,0.1]", "[\"a\",\"b\"]"},
                                      {"[[100,20.5,0.1],[200,22,0.05]]", "7"},
                                      {"{\"frame\":\"dyn_003\",\"picture\":\"watch/held-back.jpg\"}", "[]"},
                                      {"\"change\":3", "\"change\":\"x\""}}) {
        const auto p = parse(with(part, other));
        EXPECT_FALSE(p) << other;
        if (p) continue;
        EXPECT_EQ(p.error().message.substr(0, 17), "OUT/progress.json") << p.error().message;
    }
    EXPECT_EQ(parse(with("\"version\":1", "\"version\":2")).error().code, Code::Version);
    EXPECT_FALSE(parse("[]"));
    EXPECT_FALSE(parse(std::string(100000, '[')));
    EXPECT_FALSE(parse(with("[100,20.5,0.1]", std::string(RunProgress::kMostBytes, ' '))));
    std::string many = "[1,2,3]";
    for (size_t i = 0; i < RunProgress::kMostPoints; ++i) many += ",[1,2,3]";
    EXPECT_FALSE(parse(with("[100,20.5,0.1]", many)));
}

TEST(RunProgress, keepsNumbersAndTextsWithinBounds) {
    EXPECT_DOUBLE_EQ(must(parse(with("\"share\":0.15", "\"share\":7"))).share, 1);
    EXPECT_EQ(must(parse(with("\"place\":7", "\"place\":99"))).place, 11u);
    EXPECT_EQ(must(parse(with("\"places\":11", "\"places\":1e9"))).places, 1000u);
    EXPECT_DOUBLE_EQ(must(parse(with("[100,20.5,0.1]", "[-1,1e9,0]"))).curve[0].db, 1000);
    std::string umlauts;
    while (umlauts.size() < 3 * RunProgress::kMostText) umlauts += "\u00e4\u00e4x";
    const std::string cut = must(parse(with("painting", umlauts))).words;
    EXPECT_LE(cut.size(), RunProgress::kMostText + 4);
    EXPECT_EQ(cut.substr(0, 10), umlauts.substr(0, 10));
    EXPECT_NE(uint8_t(cut[cut.size() - 5]), 0xc3) << "no half character";
}

TEST(RunProgress, saysTimesAsPeopleDo) {
    EXPECT_EQ(wordsOfTimeLeft(0), "less than a minute left");
    EXPECT_EQ(wordsOfTimeLeft(50), "about 1 minute left");
    EXPECT_EQ(wordsOfTimeLeft(700), "about 12 minutes left");
    EXPECT_EQ(wordsOfTimeLeft(6000), "about 1 h 40 min left");
    EXPECT_EQ(wordsOfRunLeft(700), "about 12 minutes left in all");
    EXPECT_EQ(wordsOfTime(1500), "25 minutes");
    EXPECT_EQ(wordsOfTime(3 * 86400), "3 days");
}

TEST(RunProgress, saysOfTheRestWhatTheRunForetells) {
    RunProgress progress;
    EXPECT_EQ(wordsOfTheRest(progress), "");
    progress.place = 7, progress.places = 11;
    EXPECT_EQ(wordsOfTheRest(progress), "4 more parts come after this one; how long they take is not known yet.");
    progress.runSecondsLeft = 700;
    EXPECT_EQ(wordsOfTheRest(progress), "About 12 minutes left in all.");
    progress.place = 10, progress.runSecondsLeft.reset();
    EXPECT_EQ(wordsOfTheRest(progress), "One more part comes after this one; how long it takes is not known yet.");
    progress.place = 11, progress.runSecondsLeft = 20;
    EXPECT_EQ(wordsOfTheRest(progress), "This is the last part of the run.");
}

TEST(RunProgress, readsTheTimeOfTheRun) {
    EXPECT_FALSE(must(parse(with("\"seconds_left\":700", "\"seconds_left\":700,\"run_seconds_left\":null"))).runSecondsLeft);
    EXPECT_EQ(must(parse(with("\"seconds_left\":700", "\"seconds_left\":700,\"run_seconds_left\":900"))).runSecondsLeft, 900.0);
    EXPECT_FALSE(parse(with("\"seconds_left\":700", "\"seconds_left\":700,\"run_seconds_left\":-1")));
}

}  // namespace
