// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/pose_precision.h"

#include <gtest/gtest.h>

namespace dpl {
namespace {

/** Each entry tells its place: base + 100 · row + column. */
PosePrecision numbered(std::vector<uint32_t> joints, double base) {
    PosePrecision p;
    p.joints = std::move(joints);
    for (size_t r = 0; r < p.size(); ++r)
        for (size_t c = 0; c < p.size(); ++c) p.matrix.push_back(base + 100 * double(r) + double(c));
    return p;
}

TEST(PosePrecision, togetherAddsWhatBothSayOfAJoint) {
    const PosePrecision a = numbered({0, 2, 7}, 1e4), b = numbered({0, 5}, 2e4), sum = together(a, b);
    EXPECT_EQ(sum.joints, (std::vector<uint32_t>{0, 2, 5, 7}));
    ASSERT_EQ(sum.size(), 15u);
    ASSERT_EQ(sum.matrix.size(), 15u * 15u);
    const auto at = [](const PosePrecision& p, size_t r, size_t c) { return p.matrix[r * p.size() + c]; };
    EXPECT_EQ(at(sum, 1, 2), at(a, 1, 2) + at(b, 1, 2)) << "the root";
    EXPECT_EQ(at(sum, 14, 0), at(a, 11, 0) + at(b, 8, 0)) << "translation and root";
    EXPECT_EQ(at(sum, 3, 9), at(a, 3, 6)) << "joints 2 and 7, which a alone has";
    EXPECT_EQ(at(sum, 6, 13), at(b, 3, 7)) << "joint 5 and the translation, which b alone has";
    EXPECT_EQ(at(sum, 3, 6), 0) << "joints 2 and 5, which neither has together";
    const PosePrecision other = together(b, a);
    EXPECT_EQ(other.joints, sum.joints);
    EXPECT_EQ(other.matrix, sum.matrix);
}

}  // namespace
}  // namespace dpl
