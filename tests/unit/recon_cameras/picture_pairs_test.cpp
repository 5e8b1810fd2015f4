// SPDX-License-Identifier: Apache-2.0
// Neighbours are matched, loops are closed, and the number of pairs grows with the number of pictures.
#include "reconstruction/input/cameras/picture_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace dpl {
namespace {

bool has(const std::vector<std::pair<size_t, size_t>>& pairs, size_t a, size_t b) {
    return std::find(pairs.begin(), pairs.end(), std::pair(std::min(a, b), std::max(a, b))) != pairs.end();
}

TEST(PicturePairs, neighboursAndTheEndsOfTheWalk) {
    const auto pairs = pairsToMatch(60, 0);
    for (size_t i = 0; i < 60; ++i)
        for (size_t k = 1; k <= 3; ++k) EXPECT_TRUE(has(pairs, i, (i + k) % 60)) << i << " " << k;
}

TEST(PicturePairs, everyStillMeetsStillsAllRound) {
    const auto pairs = pairsToMatch(60, 0);
    for (size_t i = 0; i < 60; ++i) {
        std::set<size_t> sixths;
        for (size_t j = 0; j < 60; ++j)
            if (has(pairs, i, j)) sixths.insert(j / 10);
        EXPECT_EQ(sixths.size(), 6u) << i;
    }
}

TEST(PicturePairs, closeupsMeetEachOtherAndTheWalk) {
    const auto pairs = pairsToMatch(60, 10);
    for (size_t i = 0; i + 1 < 10; ++i) EXPECT_TRUE(has(pairs, 60 + i, 61 + i));
    for (size_t i = 0; i < 10; ++i) {
        size_t stills = 0;
        for (size_t j = 0; j < 60; ++j) stills += has(pairs, 60 + i, j);
        EXPECT_EQ(stills, 20u);
    }
    EXPECT_FALSE(has(pairs, 60, 69)) << "close-ups are no loop";
}

TEST(PicturePairs, valid_evenForFewPictures) {
    for (size_t stills : {0u, 1u, 2u, 3u, 5u, 13u})
        for (size_t closeups : {0u, 1u, 4u}) {
            const auto pairs = pairsToMatch(stills, closeups);
            const std::set<std::pair<size_t, size_t>> different(pairs.begin(), pairs.end());
            EXPECT_EQ(different.size(), pairs.size());
            for (const auto& [a, b] : pairs) {
                EXPECT_LT(a, b);
                EXPECT_LT(b, stills + closeups);
            }
        }
    EXPECT_EQ(pairsToMatch(3, 0).size(), 3u);
    EXPECT_LT(pairsToMatch(400, 0).size(), 400u * 12 + 1);
}

}  // namespace
}  // namespace dpl
