// SPDX-License-Identifier: Apache-2.0
// Names of frames from names of pictures.
#include <gtest/gtest.h>

#include "reconstruction/base/json_fields.h"

namespace dpl {
namespace {

TEST(Names, lettersOfEveryScriptStay) {
    EXPECT_EQ(nameFromPath("images/一.jpg"), "一");
    EXPECT_EQ(nameFromPath("Fotos/Ümläut é 1.JPG"), "Fotos_Ümläut_é_1");
    EXPECT_EQ(nameFromPath("./left cam/IMG 1.jpg"), "left_cam_IMG_1");
    EXPECT_EQ(nameFromPath("images\\кадр_001.png"), "кадр_001");
    EXPECT_EQ(nameFromPath("😀.png"), "😀");
    for (const char* name : {"一", "Ümläut", "кадр_001", "日本語.2", "😀", "a-b_c.d"}) EXPECT_TRUE(isSafeName(name)) << name;
}

TEST(Names, whatIsNoTextOrNoNameIsReplaced) {
    EXPECT_EQ(nameFromPath("a\xff"
                           "b.jpg"),
              "a_b");                               // no UTF-8
    EXPECT_EQ(nameFromPath("\xe4\xb8.jpg"), "__");  // a character that is cut
    EXPECT_EQ(nameFromPath("a\xc0\xaf"
                           "b.jpg"),
              "a__b");  // '/' in a long form
    EXPECT_EQ(nameFromPath("a\xe2\x80\xae"
                           "gpj.jpg"),
              "a___gpj");  // turns the direction of writing
    for (const char* name : {"", ".a", "a/b", "a b", "a\n", "\xff", "a\xe2\x80\xa8", "a\xed\xa0\x80", "a\xc2\x85", "\xf5\x80\x80\x80"})
        EXPECT_FALSE(isSafeName(name)) << name;
}

TEST(Names, longNamesAreCutBetweenCharacters) {
    std::string longName;
    for (int i = 0; i < 60; ++i) longName += "字";
    const std::string cut = nameFromPath(longName + ".jpg");
    EXPECT_EQ(cut.size(), 126u);
    EXPECT_TRUE(isSafeName(cut));
    EXPECT_EQ(numberedName("a", 2), "a_2");
    const std::string numbered = numberedName(cut, 12);
    EXPECT_EQ(numbered.size(), 126u);  // 41 characters of three bytes and "_12"
    EXPECT_TRUE(isSafeName(numbered));
}

}  // namespace
}  // namespace dpl
