// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/precision_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "sdk/core/files.h"

namespace dpl::test {
namespace {

PosePrecision precisionOf(std::vector<uint32_t> joints, double value) {
    PosePrecision p;
    p.joints = std::move(joints);
    p.matrix.assign(p.size() * p.size(), value);
    return p;
}

class PrecisionFile : public testing::Test {
protected:
    ~PrecisionFile() override { std::filesystem::remove(path_); }
    std::filesystem::path path_ = std::filesystem::temp_directory_path() / ("doppel_precisions_" + std::to_string(::getpid()));
};

TEST_F(PrecisionFile, givesBackWhatWasWritten) {
    const std::vector<PosePrecision> written{precisionOf({0, 2}, 3.5), precisionOf({0}, -1)};
    ASSERT_TRUE(writePrecisions(written, path_));
    const auto back = readPrecisions(path_, 2, 3);
    ASSERT_TRUE(back) << back.error().message;
    for (size_t f = 0; f < 2; ++f) {
        EXPECT_EQ((*back)[f]->joints, written[f].joints);
        EXPECT_EQ((*back)[f]->matrix, written[f].matrix);
    }
}

TEST_F(PrecisionFile, refusesWhatDoesNotFit) {
    const auto refused = [&](const PosePrecision& p, size_t frames, size_t joints) {
        EXPECT_TRUE(writePrecisions({p}, path_));
        const auto back = readPrecisions(path_, frames, joints);
        return !back && back.error().message.find(path_.string()) != std::string::npos;
    };
    EXPECT_FALSE(refused(precisionOf({0, 2}, 1), 1, 3));
    EXPECT_TRUE(refused(precisionOf({0, 2}, 1), 1, 2)) << "a joint that the rig lacks";
    EXPECT_TRUE(refused(precisionOf({0, 2}, 1), 2, 3)) << "a frame too few";
    EXPECT_TRUE(refused(precisionOf({0, 2}, 1), 0, 3)) << "a frame too many";
    EXPECT_TRUE(refused(precisionOf({1, 2}, 1), 1, 3)) << "without the root";
    EXPECT_TRUE(refused(precisionOf({0, 2, 2}, 1), 1, 3)) << "a joint twice";
    EXPECT_TRUE(refused(precisionOf({0}, NAN), 1, 3)) << "not finite";
    PosePrecision cut = precisionOf({0}, 1);
    cut.matrix.pop_back();
    EXPECT_TRUE(refused(cut, 1, 3)) << "not square";
}

TEST_F(PrecisionFile, everyTruncationIsRefused) {
    ASSERT_TRUE(writePrecisions({precisionOf({0}, 1)}, path_));
    const auto whole = readFile(path_);
    ASSERT_TRUE(whole);
    for (size_t n = 0; n < whole->size(); ++n) {
        ASSERT_TRUE(writeFileAtomically(path_, std::span(*whole).first(n)));
        EXPECT_FALSE(readPrecisions(path_, 1, 1)) << n;
    }
}

}  // namespace
}  // namespace dpl::test
