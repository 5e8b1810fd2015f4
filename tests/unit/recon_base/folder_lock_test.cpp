// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/folder_lock.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>

#include <gtest/gtest.h>

#include "tests/unit/must.h"

namespace dpl {
namespace {

class FolderLocks : public testing::Test {
protected:
    FolderLocks() { std::filesystem::create_directories(folder_); }
    ~FolderLocks() override { std::filesystem::remove_all(folder_); }
    const std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) / ("doppel_lock_" + std::to_string(::getpid()));
};

TEST_F(FolderLocks, oneRunAtATimeAndTheSecondIsToldWhoHoldsIt) {
    {
        const FolderLock first = must(FolderLock::take(folder_));
        const auto second = FolderLock::take(folder_);
        ASSERT_FALSE(second);
        EXPECT_NE(second.error().message.find(folder_.string() + " since 20"), std::string::npos) << second.error().message;
        EXPECT_NE(second.error().message.find("process " + std::to_string(::getpid())), std::string::npos) << second.error().message;
    }
    EXPECT_TRUE(FolderLock::take(folder_)) << "given back at the end of the run";
}

TEST_F(FolderLocks, aKilledRunHoldsNothing) {
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const auto held = FolderLock::take(folder_);
        const char said = held ? 'y' : 'n';
        (void)!::write(ready[1], &said, 1);
        for (;;) ::pause();
    }
    char said = 0;
    ASSERT_EQ(::read(ready[0], &said, 1), 1);
    EXPECT_EQ(said, 'y');
    EXPECT_FALSE(FolderLock::take(folder_));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_TRUE(FolderLock::take(folder_));
    ::close(ready[0]), ::close(ready[1]);
}

TEST_F(FolderLocks, aFolderThatIsNotThereIsNamed) {
    const auto lock = FolderLock::take(folder_ / "missing");
    ASSERT_FALSE(lock);
    EXPECT_NE(lock.error().message.find("missing/run.lock"), std::string::npos) << lock.error().message;
}

}  // namespace
}  // namespace dpl
