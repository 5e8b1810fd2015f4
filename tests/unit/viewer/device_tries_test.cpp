// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/device_tries.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

TEST(DeviceTries, threeWithinAMinuteAreTheMost) {
    DeviceTries tries;
    for (const double nowS : {10.0, 12.0, 14.0}) EXPECT_TRUE(tries.take(nowS)) << nowS;
    EXPECT_FALSE(tries.take(16));
    EXPECT_FALSE(tries.take(69.9));
}

TEST(DeviceTries, oldOnesDoNotCount) {
    DeviceTries tries;
    for (int loss = 0; loss < 100; ++loss) EXPECT_TRUE(tries.take(loss * DeviceTries::kWithinS / 2)) << "a loss every half minute";
    DeviceTries late;
    late.take(0), late.take(30), late.take(40);
    EXPECT_FALSE(late.take(59));
    EXPECT_TRUE(late.take(60)) << "the first is a minute old";
    EXPECT_FALSE(late.take(61));
}

}  // namespace
