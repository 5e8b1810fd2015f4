// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/playback.h"

#include <gtest/gtest.h>

#include "apps/viewer/messages.h"

namespace {

using namespace dpl;

TEST(Playback, runsAtItsSpeedUnlessPaused) {
    Playback playback;
    playback.advance(0.5);
    EXPECT_DOUBLE_EQ(playback.timeS, 0.5);
    playback.speed = -2;
    playback.advance(0.5);
    EXPECT_DOUBLE_EQ(playback.timeS, -0.5);
    playback.playing = false;
    playback.advance(10);
    EXPECT_DOUBLE_EQ(playback.timeS, -0.5);
}

TEST(Playback, timeWrapsIntoTheClip) {
    EXPECT_DOUBLE_EQ(timeInClip(0.25, 2), 0.25);
    EXPECT_DOUBLE_EQ(timeInClip(2, 2), 0);
    EXPECT_DOUBLE_EQ(timeInClip(7.5, 2), 1.5);
    EXPECT_DOUBLE_EQ(timeInClip(-0.5, 2), 1.5);
    EXPECT_EQ(timeInClip(3, 0), 0);
    for (const double tiny : {-1e-20, -1e-300}) {
        EXPECT_GE(timeInClip(tiny, 2), 0);
        EXPECT_LT(timeInClip(tiny, 2), 2);
    }
}

TEST(Playback, withoutLoopTimeStopsAtTheEnds) {
    EXPECT_DOUBLE_EQ(timeInClip(1.5, 2, false), 1.5);
    EXPECT_DOUBLE_EQ(timeInClip(7.5, 2, false), 2);
    EXPECT_DOUBLE_EQ(timeInClip(-1, 2, false), 0);
    EXPECT_EQ(timeInClip(3, 0, false), 0);
}

TEST(Messages, errorsStayAndOtherLinesGo) {
    Messages messages;
    messages.error("broken");
    messages.info("saved", 10);
    messages.tick(10 + Messages::kSecondsShown - 0.1);
    EXPECT_EQ(messages.lines().size(), 2u);
    messages.tick(10 + Messages::kSecondsShown);
    ASSERT_EQ(messages.lines().size(), 1u);
    EXPECT_EQ(messages.lines()[0].text, "broken");
    messages.dismiss(0);
    messages.dismiss(0);
    EXPECT_TRUE(messages.lines().empty());
}

TEST(Messages, anErrorIsShownOnceAndOldLinesGiveWay) {
    Messages messages;
    messages.error("a");
    messages.error("a");
    EXPECT_EQ(messages.lines().size(), 1u);
    for (const char* text : {"b", "c", "d", "e"}) messages.error(text);
    ASSERT_EQ(messages.lines().size(), Messages::kMost);
    EXPECT_EQ(messages.lines()[0].text, "b");
}

}  // namespace
