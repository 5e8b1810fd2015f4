// SPDX-License-Identifier: Apache-2.0
// Writes zip archives for tests.
#pragma once

#include <zlib.h>

#include <string>
#include <utility>
#include <vector>

#include "sdk/core/writer.h"

namespace dpl {

/** A zip whose entries are alternately deflated and stored. */
inline std::vector<uint8_t> zip(const std::vector<std::pair<std::string, std::vector<uint8_t>>>& entries) {
    Writer out, directory;
    uint16_t count = 0;
    for (const auto& entry : entries) {
        const std::string& name = entry.first;
        const std::vector<uint8_t>& plain = entry.second;
        std::vector<uint8_t> stored = plain;
        const bool deflated = count % 2 == 0;
        if (deflated) {
            z_stream z{};
            deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
            stored.resize(deflateBound(&z, uLong(plain.size())));
            z.next_in = const_cast<Bytef*>(plain.data()), z.avail_in = uInt(plain.size());
            z.next_out = stored.data(), z.avail_out = uInt(stored.size());
            deflate(&z, Z_FINISH);
            stored.resize(z.total_out);
            deflateEnd(&z);
        }
        const uint32_t offset = uint32_t(out.size()), crc = uint32_t(crc32(0, plain.data(), uInt(plain.size())));
        const auto common = [&](Writer& w) {
            w.value(uint16_t(0)), w.value(uint16_t(deflated ? 8 : 0)), w.value(uint32_t(0)), w.value(crc);
            w.value(uint32_t(stored.size())), w.value(uint32_t(plain.size())), w.value(uint16_t(name.size())), w.value(uint16_t(0));
        };
        const std::span<const uint8_t> nameBytes(reinterpret_cast<const uint8_t*>(name.data()), name.size());
        out.value(uint32_t(0x04034b50)), out.value(uint16_t(20));
        common(out);
        out.append(nameBytes), out.append(stored);
        directory.value(uint32_t(0x02014b50)), directory.value(uint16_t(20)), directory.value(uint16_t(20));
        common(directory);
        directory.value(uint16_t(0)), directory.value(uint16_t(0)), directory.value(uint16_t(0)), directory.value(uint32_t(0)),
            directory.value(offset);
        directory.append(nameBytes);
        ++count;
    }
    const uint32_t begin = uint32_t(out.size());
    const auto bytes = directory.finish();
    out.append(bytes);
    out.value(uint32_t(0x06054b50)), out.value(uint16_t(0)), out.value(uint16_t(0)), out.value(count), out.value(count),
        out.value(uint32_t(bytes.size())), out.value(begin), out.value(uint16_t(0));
    return out.finish();
}

}  // namespace dpl
