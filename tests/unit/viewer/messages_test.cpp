// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/messages.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

TEST(Messages, errorsStayAndOthersGoButTheLogKeepsAll) {
    Messages messages;
    messages.tick(1);
    messages.info("saved", 1);
    messages.error("no disk");
    messages.error("no disk");
    messages.note("the library said so", false);
    ASSERT_EQ(messages.lines().size(), 2u);
    messages.tick(1 + Messages::kSecondsShown);
    ASSERT_EQ(messages.lines().size(), 1u);
    messages.dismiss(0);
    EXPECT_TRUE(messages.lines().empty());
    ASSERT_EQ(messages.log().size(), 3u);
    EXPECT_EQ(messages.log()[1].text, "no disk");
    EXPECT_TRUE(messages.log()[1].error);
    EXPECT_EQ(messages.log()[2].atS, 1);
    for (int i = 0; i < 600; ++i) messages.note(std::to_string(i), false);
    ASSERT_EQ(messages.log().size(), Messages::kMostKept);
    EXPECT_EQ(messages.log().back().text, "599");
}

}  // namespace
