// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/comparison.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

TEST(Comparison, asksForOneFrameAtATimeAndSkipsThoseInBetween) {
    Comparison c;
    ASSERT_EQ(c.next(), 0u) << "the first is asked for before their names are known";
    EXPECT_FALSE(c.next());
    c.setFrames({"a", "b", "c", "d"});
    c.arrived(0);
    EXPECT_TRUE(c.isShown());
    EXPECT_FALSE(c.next());
    c.step(1);
    EXPECT_FALSE(c.isShown());
    ASSERT_EQ(c.next(), 1u);
    c.step(1), c.step(1);
    EXPECT_FALSE(c.next()) << "b is on its way";
    c.arrived(1);
    EXPECT_FALSE(c.isShown());
    EXPECT_EQ(c.next(), 3u) << "c is skipped";
}

TEST(Comparison, aFrameThatCannotBeDrawnIsNotAskedForAgain) {
    Comparison c;
    c.setFrames({"a", "b"});
    ASSERT_EQ(c.next(), 0u);
    c.arrived(0);
    EXPECT_FALSE(c.next());
    c.step(1);
    EXPECT_EQ(c.next(), 1u);
}

TEST(Comparison, staysWithinItsFrames) {
    Comparison c;
    c.setFrames({"a", "b", "c"});
    c.step(-1);
    EXPECT_EQ(c.frame(), 0u);
    c.step(1000);
    EXPECT_EQ(c.frame(), 2u);
    c.choose(size_t(-1));
    EXPECT_EQ(c.frame(), 2u);
    c.setFrames({"a", "b"});
    EXPECT_EQ(c.frame(), 1u);
}

}  // namespace
