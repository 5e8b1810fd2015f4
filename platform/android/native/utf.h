// SPDX-License-Identifier: Apache-2.0
// UTF-8 and UTF-16. Whatever is no character becomes U+FFFD, so that names from damaged files reach people as text.
#pragma once

#include <string>
#include <string_view>

namespace dpl::android {

std::u16string utf16Of(std::string_view utf8);
std::string utf8Of(std::u16string_view utf16);

}  // namespace dpl::android
