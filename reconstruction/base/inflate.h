// SPDX-License-Identifier: Apache-2.0
// zlib inflate with a limit on the unpacked size, for compressed files from outside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

enum class DeflateWrapper : uint8_t { Gzip, Raw };  // Gzip: a .gz file; Raw: a zip entry

/** Inflates all of `compressed`. CorruptData when it is damaged, truncated or unpacks to more than `maxBytes`. */
Result<std::vector<uint8_t>> inflateBytes(std::span<const uint8_t> compressed, DeflateWrapper wrapper, size_t maxBytes);

}  // namespace dpl
