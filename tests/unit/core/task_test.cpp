// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/task.h"

#include <gtest/gtest.h>

namespace dpl {
namespace {

TEST(Task, partsNestAndProgressNeverFalls) {
    Task task;
    const TaskScope scope(&task);
    {
        const TaskPart half(0, 0.5);
        EXPECT_TRUE(taskAt(0.5));
        EXPECT_EQ(task.progress(), 0.25);
        {
            const TaskPart rest(0.5, 1);
            EXPECT_TRUE(taskAt(0.5));
            EXPECT_EQ(task.progress(), 0.375);
        }
        EXPECT_TRUE(taskAt(0.1));
        EXPECT_EQ(task.progress(), 0.375);
    }
    const TaskPart second(0.5, 1);
    EXPECT_EQ(task.progress(), 0.5) << "what comes before a part is done";
    EXPECT_TRUE(taskAt(2));
    EXPECT_EQ(task.progress(), 1);
}

TEST(Task, hearsWhatIsDoneWithTheShareOfTheWhole) {
    struct Listener : Task {
        std::vector<std::pair<double, std::string>> heard;
        void hear(double share, std::string_view doing) override { heard.emplace_back(share, doing); }
    } whole, inner;
    const TaskScope scope(&whole);
    const TaskPart half(0.5, 1);
    EXPECT_TRUE(taskAt(0.25)) << "nothing to tell";
    EXPECT_TRUE(taskAt(0.5, "frame 3"));
    {
        const TaskScope nested(&inner);
        EXPECT_TRUE(taskAt(0.5, "on its own"));
    }
    EXPECT_TRUE(taskAt(1, "done"));
    EXPECT_EQ(whole.heard, (std::vector<std::pair<double, std::string>>{{0.75, "frame 3"}, {1, "done"}}));
    EXPECT_EQ(inner.heard, (std::vector<std::pair<double, std::string>>{{0.5, "on its own"}})) << "the part around it is another task's";
}

TEST(Task, cancellingIsSeenByTheThreadOfTheTaskAlone) {
    Task task;
    EXPECT_TRUE(taskAt(0.5)) << "no task";
    {
        const TaskScope scope(&task);
        EXPECT_TRUE(taskAt(0.5));
        task.cancel();
        ASSERT_FALSE(taskAt(0.6));
        EXPECT_EQ(taskAt(0.6).error().code, Code::Cancelled);
        EXPECT_EQ(task.progress(), 0.5);
        const TaskScope none(nullptr);
        EXPECT_TRUE(taskAt(0.7));
    }
    EXPECT_TRUE(taskAt(0.8));
}

}  // namespace
}  // namespace dpl
