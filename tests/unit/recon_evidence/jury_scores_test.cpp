// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/evidence/jury_scores.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>

#include "sdk/core/files.h"

namespace dpl {
namespace {

class JuryScoresTest : public testing::Test {
protected:
    ~JuryScoresTest() override { std::filesystem::remove(file_); }
    const std::filesystem::path file_ = std::filesystem::temp_directory_path() / ("doppel_scores_" + std::to_string(::getpid()) + ".json");
};

TEST_F(JuryScoresTest, theNextRunReadsTheSameNumbers) {
    const JuryScore odd{1.0 / 3, 0.1 + 0.2, {5e-324, 1 - std::numeric_limits<double>::epsilon()}}, other{-4, 0, {1, 0}};
    {
        JuryScores scores(file_);
        EXPECT_FALSE(scores.find("nothing"));
        ASSERT_TRUE(scores.add("nothing", odd));
        ASSERT_TRUE(scores.add("light", other));
    }
    const JuryScores read(file_);
    EXPECT_EQ(read.find("nothing"), odd);
    EXPECT_EQ(read.find("light"), other);
    EXPECT_FALSE(read.find("offsets"));
}

TEST_F(JuryScoresTest, damageCostsScoresAndNothingElse) {
    JuryScores scores(file_);
    ASSERT_TRUE(scores.add("nothing", {20, 1, {}}));
    const auto bytes = *readFile(file_);
    const std::string text(bytes.begin(), bytes.end());
    for (const std::string& damaged : {text.substr(0, text.size() / 2), std::string("[]"), std::string(R"({"nothing": 3})"),
                                       std::string(R"({"nothing": {"masked_psnr_db": null, "detail": 1}})")}) {
        ASSERT_TRUE(writeFileAtomically(file_, damaged));
        EXPECT_FALSE(JuryScores(file_).find("nothing")) << damaged;
    }
}

TEST_F(JuryScoresTest, aNumberThatIsNotFiniteIsJudgedAgain) {
    JuryScores scores(file_);
    ASSERT_TRUE(scores.add("nothing", {std::numeric_limits<double>::quiet_NaN(), 1, {}}));
    EXPECT_FALSE(JuryScores(file_).find("nothing"));
}

}  // namespace
}  // namespace dpl
