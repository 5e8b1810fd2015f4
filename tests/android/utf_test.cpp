// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/utf.h"

#include <gtest/gtest.h>

namespace dpl::android {
namespace {

TEST(Utf, goesThereAndBackAtEveryLength) {
    const std::string text = "Ada \xC3\xA9 \xE2\x82\xAC \xF0\x9F\x99\x82 \xF4\x8F\xBF\xBF";
    EXPECT_EQ(utf16Of(text), u"Ada \u00E9 \u20AC \U0001F642 \U0010FFFF");
    EXPECT_EQ(utf8Of(utf16Of(text)), text);
    EXPECT_EQ(utf8Of(std::u16string_view(u"\0", 1)), std::string(1, '\0'));
}

TEST(Utf, replacesWhatIsNoCharacter) {
    // A lone continuation, overlong forms, a surrogate, beyond the last code point, a lead byte that does not exist.
    for (const std::string bad : {"\x80", "\xC0\xAF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
        const std::u16string out = utf16Of("a" + bad + "b");
        EXPECT_EQ(out.front(), u'a');
        EXPECT_EQ(out.back(), u'b');
        EXPECT_EQ(out.substr(1, out.size() - 2), std::u16string(bad.size(), u'\uFFFD'));
    }
    EXPECT_EQ(utf8Of(std::u16string(1, char16_t(0xD83D))), "\xEF\xBF\xBD");
    EXPECT_EQ(utf8Of(std::u16string{char16_t(0xDE42), u'x'}), "\xEF\xBF\xBDx");
}

TEST(Utf, everyTruncationOfACharacterIsReplaced) {
    const std::string text = "\xF0\x9F\x99\x82";
    for (size_t length = 1; length < text.size(); ++length) EXPECT_EQ(utf16Of(text.substr(0, length)), std::u16string(length, u'\uFFFD'));
}

}  // namespace
}  // namespace dpl::android
