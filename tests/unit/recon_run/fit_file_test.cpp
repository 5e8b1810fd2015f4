// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/fit_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "sdk/core/files.h"
#include "tests/unit/must.h"

namespace dpl::test {
namespace {

class HandsFile : public testing::Test {
protected:
    ~HandsFile() override { std::filesystem::remove(file_); }
    const std::filesystem::path file_ = std::filesystem::temp_directory_path() / ("doppel_hands_" + std::to_string(::getpid()) + ".json");
};

TEST_F(HandsFile, isReadAsItWasWritten) {
    const std::vector<HandFit> hands{{true, true, 12, 45, 24, 1.0 / 3}, {false, false, 0, 7, 0, 0}};
    ASSERT_TRUE(writeFileAtomically(file_, handsToJson(hands)));
    const std::vector<HandFit> read = must(readHandsFile(file_));
    ASSERT_EQ(read.size(), 2u);
    EXPECT_TRUE(read[0].left && read[0].turned);
    EXPECT_FALSE(read[1].left || read[1].turned);
    EXPECT_EQ(read[0].stillFrames, 12u);
    EXPECT_EQ(read[0].movingFrames, 45u);
    EXPECT_EQ(read[0].posedFrames, 24u);
    EXPECT_EQ(read[0].medianPx, 1.0 / 3);
    EXPECT_EQ(read[1].movingFrames, 7u);
}

TEST_F(HandsFile, damageIsRefusedByASentenceThatNamesTheFile) {
    const std::string good = handsToJson(std::vector<HandFit>{{}});
    for (const std::string& damaged :
         {good.substr(0, good.size() / 2), std::string("[]"), std::string("{}"), std::string("3"), std::string("[{\"left\": 1}]")}) {
        ASSERT_TRUE(writeFileAtomically(file_, damaged));
        const auto read = readHandsFile(file_);
        ASSERT_FALSE(read) << damaged;
        EXPECT_NE(read.error().message.find(file_.string()), std::string::npos) << read.error().message;
    }
}

}  // namespace
}  // namespace dpl::test
