// SPDX-License-Identifier: Apache-2.0
// zlib inflate with a hard limit on what may come out, for the importers' compressed inputs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

enum class DeflateWrapper : uint8_t { Gzip, Raw };  // a .gz file; a zip entry

/** Inflates all of `compressed`. CorruptData when the stream is damaged, truncated or longer than `maxBytes` when unpacked. */
Result<std::vector<uint8_t>> inflateBytes(std::span<const uint8_t> compressed, DeflateWrapper wrapper, size_t maxBytes);

}  // namespace dpl
