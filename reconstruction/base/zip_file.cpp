// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/zip_file.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "reconstruction/base/inflate.h"
#include "reconstruction/base/value_at.h"
#include "sdk/core/reader.h"

namespace dpl {
namespace {

constexpr uint32_t kLocalHeader = 0x04034b50, kDirectoryEntry = 0x02014b50, kDirectoryEnd = 0x06054b50;
constexpr size_t kDirectoryEndBytes = 22, kMaxCommentBytes = 65535;

}  // namespace

Result<ZipFile> ZipFile::open(std::span<const uint8_t> bytes) {
    if (bytes.size() < kDirectoryEndBytes) return fail(Code::CorruptData, "too short to be a zip archive");
    size_t end = bytes.size() - kDirectoryEndBytes;
    const size_t lowest = end > kMaxCommentBytes ? end - kMaxCommentBytes : 0;
    while (valueAt<uint32_t>(bytes, end) != kDirectoryEnd) {
        if (end == lowest) return fail(Code::CorruptData, "not a zip archive, or cut short: it has no directory");
        --end;
    }
    const uint16_t entryCount = valueAt<uint16_t>(bytes, end + 10);
    const uint32_t directoryOffset = valueAt<uint32_t>(bytes, end + 16);
    if (directoryOffset > end) return fail(Code::CorruptData, "the zip directory lies outside the file");
    Reader directory(bytes.subspan(directoryOffset, end - directoryOffset));
    ZipFile file;
    for (uint16_t i = 0; i < entryCount; ++i) {
        DPL_TRY(const auto e, directory.take(46));
        if (valueAt<uint32_t>(e, 0) != kDirectoryEntry) return fail(Code::CorruptData, "entry {} of the zip directory is damaged", i);
        const uint16_t flags = valueAt<uint16_t>(e, 8), method = valueAt<uint16_t>(e, 10);
        const uint32_t stored = valueAt<uint32_t>(e, 20), plain = valueAt<uint32_t>(e, 24), offset = valueAt<uint32_t>(e, 42);
        DPL_TRY(const auto nameRaw, directory.take(valueAt<uint16_t>(e, 28)));
        DPL_RETURN_IF_ERROR(directory.skip(size_t(valueAt<uint16_t>(e, 30)) + valueAt<uint16_t>(e, 32)));
        std::string name(nameRaw.begin(), nameRaw.end());
        if ((flags & 1) || (method != 0 && method != 8) || stored == UINT32_MAX || plain == UINT32_MAX || offset == UINT32_MAX)
            return fail(Code::Unsupported,
                        "'{}' is encrypted, zip64 or compressed in a way we do not read; pack it again with plain deflate", name);
        // Skip the local header's own name and extra field: their lengths may differ from the directory's.
        if (offset > bytes.size() || bytes.size() - offset < 30 || valueAt<uint32_t>(bytes, offset) != kLocalHeader)
            return fail(Code::CorruptData, "'{}' lies outside the file", name);
        const uint64_t begin = uint64_t(offset) + 30 + valueAt<uint16_t>(bytes, offset + 26) + valueAt<uint16_t>(bytes, offset + 28);
        if (begin > bytes.size() || stored > bytes.size() - begin) return fail(Code::CorruptData, "'{}' is cut short", name);
        file.entries_[name] = {bytes.subspan(size_t(begin), stored), plain, valueAt<uint32_t>(e, 16), method == 8};
    }
    return file;
}

std::vector<std::string> ZipFile::names() const {
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_) names.push_back(name);
    return names;
}

size_t ZipFile::plainBytes(const std::string& name) const {
    const auto entry = entries_.find(name);
    return entry == entries_.end() ? 0 : entry->second.plainBytes;
}

Result<std::vector<uint8_t>> ZipFile::read(const std::string& name, size_t maxBytes) const {
    const auto found = entries_.find(name);
    if (found == entries_.end()) return fail(Code::NotFound, "'{}' is missing", name);
    const Entry& entry = found->second;
    if (entry.plainBytes > maxBytes) return fail(Code::Unsupported, "'{}' has {} bytes, the limit is {}", name, entry.plainBytes, maxBytes);
    std::vector<uint8_t> bytes(entry.deflated ? 0 : entry.stored.size());
    if (entry.deflated) {
        auto plain = inflateBytes(entry.stored, DeflateWrapper::Raw, entry.plainBytes + 1);  // one more, so that a longer stream is noticed
        if (!plain) return fail(plain.error().code, "'{}': {}", name, plain.error().message);
        bytes = std::move(*plain);
    } else {
        std::copy(entry.stored.begin(), entry.stored.end(), bytes.begin());
    }
    if (bytes.size() != entry.plainBytes)
        return fail(Code::CorruptData, "'{}' unpacks to {} bytes, the directory says {}", name, bytes.size(), entry.plainBytes);
    if (crc32_z(0, bytes.data(), bytes.size()) != entry.crc) return fail(Code::CorruptData, "'{}' is damaged: its checksum is wrong", name);
    return bytes;
}

}  // namespace dpl
