// SPDX-License-Identifier: Apache-2.0
// A folder of a test's own, with programs that stand in for doppel.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "sdk/core/files.h"

namespace dpl::test {

class FolderTest : public ::testing::Test {
protected:
    void SetUp() override {
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    /** An executable shell script in the folder. */
    std::filesystem::path program(const std::string& script, const std::string& name = "doppel") const {
        const std::filesystem::path path = folder_ / name;
        const std::string text = "#!/bin/sh\n" + script + "\n";
        EXPECT_TRUE(writeFileAtomically(path, std::string_view(text)));
        std::filesystem::permissions(path, std::filesystem::perms::owner_all);
        return path;
    }

    const std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() /
        (std::string("doppel-") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + "-" + std::to_string(::getpid()));
};

}  // namespace dpl::test
