// SPDX-License-Identifier: Apache-2.0
// The header of an SPZ file and the sizes of its attributes, for its reader and its writer. Internal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sdk/math/sh.h"

namespace dpl::spz {

constexpr uint32_t kMagic = 0x5053474e;  // "NGSP"
constexpr uint32_t kMaxFractionalBits = 23;
constexpr uint8_t kAntialiasedFlag = 1, kExtensionFlag = 2;
constexpr size_t kAttributes = 6;
constexpr size_t kHeader4Bytes = 32;  // of version 4: Header, the place of the table of streams, 12 reserved bytes

struct Header {
    uint32_t magic, version, splats;
    uint8_t shDegree, fractionalBits, flags, streams;  // streams: their number in version 4; else reserved
};
static_assert(sizeof(Header) == 16);

/** Bytes of each attribute: position, alpha, colour, log scale, rotation, SH of bands 1 and up. */
inline std::array<uint64_t, kAttributes> attributeBytes(const Header& h) {
    const uint64_t n = h.splats;
    return {9 * n, n, 3 * n, 3 * n, (h.version == 2 ? 3 : 4) * n, 3 * n * (shCoefficientCount(h.shDegree) - 1)};
}

}  // namespace dpl::spz
