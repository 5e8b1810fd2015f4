// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/lone_parts.h"

#include <algorithm>
#include <string_view>

#include <gtest/gtest.h>

namespace dpl {
namespace {

constexpr uint32_t kWidth = 8;

/** loneParts() of a picture in letters: '.' nothing, 'd' drawn, 'm' the person's and not drawn, 'x' both. Lone pixels come back as 'L'. */
std::string lone(std::string picture) {
    std::vector<uint8_t> drawn, person;
    for (const char c : picture) drawn.push_back(c == 'd' || c == 'x'), person.push_back(c == 'm' || c == 'x');
    const std::vector<uint8_t> parts = loneParts(drawn, person, kWidth, uint32_t(picture.size()) / kWidth);
    for (size_t i = 0; i < picture.size(); ++i)
        if (parts.at(i)) picture[i] = 'L';
    return picture;
}

TEST(LoneParts, aSpeckIsLoneAndWhatTouchesThePersonByACornerIsNot) {
    EXPECT_EQ(lone("xxx...d."
                   "xxx....."
                   "xxx...dd"
                   "...d...."),
              "xxx...L."
              "xxx....."
              "xxx...LL"
              "...d....");
}

TEST(LoneParts, aPartThatTheMaskShowsIsThePersons) {
    EXPECT_EQ(lone("xxxm..dx"
                   "xxx....."),
              "xxxm..dx"
              "xxx.....");
}

TEST(LoneParts, theLargestPartIsNeverLone) {
    EXPECT_EQ(lone("mmm..ddd"
                   "mmm..ddd"
                   "mmm....."
                   "mm..d..."),
              "mmm..ddd"
              "mmm..ddd"
              "mmm....."
              "mm..L...");
}

TEST(LoneParts, nothingDrawnAndSizesThatDifferGiveNone) {
    EXPECT_EQ(lone("..mm...."), "..mm....");
    EXPECT_TRUE(loneParts({}, {}, 0, 0).empty());
    EXPECT_TRUE(loneParts(std::vector<uint8_t>(8), std::vector<uint8_t>(7), 8, 1).empty());
}

}  // namespace
}  // namespace dpl
