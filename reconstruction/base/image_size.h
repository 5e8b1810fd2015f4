// SPDX-License-Identifier: Apache-2.0
// The largest picture that is read.
#pragma once

#include <string_view>

#include "sdk/core/result.h"

namespace dpl {

constexpr uint64_t kMaxImagePixels = 64ull << 20;  // 67.1 million; larger pictures are refused before they are decoded

/** Refuses sizes of zero or above kMaxImagePixels. `where` starts the message: file and entry. */
Status checkImageSize(uint64_t widthPx, uint64_t heightPx, std::string_view where);

}  // namespace dpl
