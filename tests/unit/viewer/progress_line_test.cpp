// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/progress_line.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

TEST(ProgressLineTest, readsWhatTheProgramPrints) {
    const auto line = parseProgressLine("  export              [######..................]  25 %  12 s left  frame 3 of 10");
    ASSERT_TRUE(line);
    EXPECT_EQ(line->stage, "export");
    EXPECT_DOUBLE_EQ(line->share, 0.25);
    EXPECT_EQ(line->left, "12 s left");
    EXPECT_EQ(line->detail, "frame 3 of 10");
    const auto run =
        parseProgressLine("  surface             [######..................]  25 %  12 s left, about 3 minutes left in all  frame 3");
    ASSERT_TRUE(run);
    EXPECT_EQ(run->left, "12 s left, about 3 minutes left in all");
    EXPECT_EQ(run->detail, "frame 3");
    const auto early =
        parseProgressLine("  surface             [#.......................]   6 %  about 2 minutes left in all  15 silhouettes");
    ASSERT_TRUE(early);
    EXPECT_EQ(early->left, "about 2 minutes left in all");
    EXPECT_EQ(early->detail, "15 silhouettes");
    const auto begun = parseProgressLine("  looking at pictures [........................]   0 %    80 left arms");
    ASSERT_TRUE(begun);
    EXPECT_EQ(begun->stage, "looking at pictures");
    EXPECT_DOUBLE_EQ(begun->share, 0);
    const auto long_ = parseProgressLine("  painting            [########################] 100 %  2 min 5 s left  ");
    ASSERT_TRUE(long_);
    EXPECT_EQ(long_->left, "2 min 5 s left");
    EXPECT_EQ(long_->detail, "");
}

TEST(ProgressLineTest, refusesOtherLines) {
    for (const char* line : {"", "doppel: no such file", "  export              done  (12 s)", "  a [b] 30 % of it",
                             "[########################]", "[########################] many %", "[########################] 101 %",
                             "[#######################] 10 %", "[#######x................] 10 %", "[########################"})
        EXPECT_FALSE(parseProgressLine(line)) << line;
}

}  // namespace
