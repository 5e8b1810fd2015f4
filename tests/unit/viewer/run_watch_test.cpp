// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_watch.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;
using Life = RunWatch::Life;

RunLook told(double beat, RunProgress::State state = RunProgress::State::Running) {
    RunLook look;
    look.kind = RunLook::Kind::Told;
    look.progress.state = state;
    look.progress.beat = beat, look.progress.unixS = 1000 + 2 * beat, look.progress.startedUnixS = 1000;
    look.progress.words = "painting", look.progress.place = 7, look.progress.places = 11;
    return look;
}

RunLook untold(RunLook::Kind kind, const std::string& sentence) {
    RunLook look;
    look.kind = kind, look.sentence = sentence;
    return look;
}

TEST(RunWatch, saysWhatARunDoes) {
    RunWatch watch("out");
    RunLook look = told(1);
    watch.hear(look, 0, 1002);
    EXPECT_EQ(watch.life(0), Life::Running);
    EXPECT_EQ(watch.sentence(0), "Painting, part 7 of 11.");
    EXPECT_EQ(watch.wordsOfFit(), "");
    look.progress.curve = {{100, 20}, {600, 25.34}}, look.progress.steps = 3000;
    watch.hear(look, 1, 1003);
    EXPECT_EQ(watch.sentence(1), "Painting, part 7 of 11.");
    EXPECT_EQ(watch.wordsOfFit(), "25.3 dB at step 600 of 3000");
    look.progress.words = "reading the film", look.progress.place = 0;
    watch.hear(look, 2, 1004);
    EXPECT_EQ(watch.sentence(2), "Reading the film.");
}

TEST(RunWatch, aRunThatBeatsLives) {
    RunWatch watch("out");
    for (int s = 0; s < 100; ++s) {
        watch.hear(told(s / 2), s, 1000 + s);
        EXPECT_EQ(watch.life(s), Life::Running) << s;
    }
}

TEST(RunWatch, aRunThatStopsBeatingIsSilentAndComesBack) {
    RunWatch watch("out");
    watch.hear(told(5), 100, 1010);
    watch.hear(told(5), 100 + RunWatch::kSilentS, 1040);
    EXPECT_EQ(watch.life(100 + RunWatch::kSilentS), Life::Running);
    EXPECT_EQ(watch.life(101 + RunWatch::kSilentS), Life::Silent);
    EXPECT_EQ(watch.sentence(140).substr(0, 29), "Not heard of for 40 seconds. ");
    EXPECT_EQ(watch.sentence(400), "Not heard of for 5 minutes. If the run was killed, the same command goes on with it.");
    RunLook again = told(5);  // the first words of another process may have the same beat
    again.progress.startedUnixS = 1500;
    watch.hear(again, 500, 1510);
    EXPECT_EQ(watch.life(501), Life::Running);
}

TEST(RunWatch, aRunThatWasStoppedWithoutALastWordIsStopped) {
    RunWatch watch("out");
    watch.hear(told(5), 0, 1010);
    watch.knowStopped();
    EXPECT_EQ(watch.life(0), Life::Stopped);
    watch.hear(told(6), 1, 1012);  // what it wrote before it ended
    EXPECT_EQ(watch.life(1), Life::Stopped);
    RunLook goesOn = told(1);
    goesOn.progress.startedUnixS = 1500;
    watch.hear(goesOn, 2, 1502);
    EXPECT_EQ(watch.life(2), Life::Running);
}

TEST(RunWatch, aRunThatDiedLongAgoIsKnownSoon) {
    RunWatch watch("out");
    watch.hear(told(5), 10, 90000);
    EXPECT_EQ(watch.life(11), Life::Running) << "its machine may have another clock";
    EXPECT_EQ(watch.life(10 + RunWatch::kFirstLookS + 1), Life::Silent);
    watch.hear(told(6), 20, 90010);
    EXPECT_EQ(watch.life(20 + RunWatch::kFirstLookS + 1), Life::Running) << "it does live";
}

TEST(RunWatch, saysHowARunEnded) {
    RunWatch watch("out");
    RunLook look = told(9, RunProgress::State::Done);
    look.progress.seconds = 1500;
    watch.hear(look, 0, 1018);
    EXPECT_EQ(watch.life(1000), Life::Done);
    EXPECT_EQ(watch.sentence(1000), "Done after 25 minutes.");
    watch.hear(told(9, RunProgress::State::Stopped), 1, 1019);
    EXPECT_EQ(watch.life(1000), Life::Stopped);
    look = told(9, RunProgress::State::Failed);
    look.progress.sentence = "painting: no space left on device";
    watch.hear(look, 2, 1020);
    EXPECT_EQ(watch.sentence(1000), "Failed: painting: no space left on device");
}

TEST(RunWatch, aDamagedFileIsWaitedOutAndADeletedRunIsSaid) {
    RunWatch watch("out");
    watch.hear(untold(RunLook::Kind::Damaged, "out/progress.json: not valid JSON"), 0, 1000);
    EXPECT_EQ(watch.life(0), Life::Unknown);
    EXPECT_EQ(watch.sentence(0), "out/progress.json: not valid JSON");
    watch.hear(told(3), 1, 1006);
    watch.hear(untold(RunLook::Kind::Damaged, "out/progress.json: not valid JSON"), 2, 1007);
    EXPECT_EQ(watch.sentence(2), "Painting, part 7 of 11.") << "what was read last holds";
    watch.hear(untold(RunLook::Kind::Gone, "The folder out is gone; what was drawn stays."), 3, 1008);
    EXPECT_EQ(watch.life(3), Life::Unknown);
    EXPECT_EQ(watch.sentence(3), "The folder out is gone; what was drawn stays.");
}

}  // namespace
