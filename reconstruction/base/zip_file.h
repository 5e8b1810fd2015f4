// SPDX-License-Identifier: Apache-2.0
// Reads zip archives, with limits on size. Follows PKWARE's APPNOTE 6.3.3, without zip64, encryption and any compression but deflate.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

class ZipFile {
public:
    /** Checks the directory. CorruptData when it is damaged, Unsupported for zip64 and encryption. The bytes must outlive the object. */
    static Result<ZipFile> open(std::span<const uint8_t> bytes);

    bool has(const std::string& name) const { return entries_.count(name) != 0; }
    /** Names of all entries, as stored: paths with slashes, unchecked. */
    std::vector<std::string> names() const;
    /** Bytes of an entry once unpacked, as the directory states them; 0 if there is none. */
    size_t plainBytes(const std::string& name) const;
    /** Unpacks one entry, of at most `maxBytes`, and checks its CRC-32. Allocates no more than the size that the directory states. */
    Result<std::vector<uint8_t>> read(const std::string& name, size_t maxBytes) const;

private:
    struct Entry {
        std::span<const uint8_t> stored;
        size_t plainBytes = 0;
        uint32_t crc = 0;
        bool deflated = false;
    };
    std::map<std::string, Entry> entries_;
};

}  // namespace dpl
