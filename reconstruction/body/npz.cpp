// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/body/npz.h"

#include <charconv>
#include <cstring>
#include <string_view>

#include "reconstruction/body/inflate.h"
#include "sdk/core/reader.h"

namespace dpl {
namespace {

constexpr uint32_t kLocalHeader = 0x04034b50, kDirectoryEntry = 0x02014b50, kDirectoryEnd = 0x06054b50;
constexpr size_t kDirectoryEndBytes = 22, kMaxCommentBytes = 65535;

template <class T>
T at(std::span<const uint8_t> bytes, size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
}

/** The text after `key` in a header such as {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }. */
std::string_view valueOf(std::string_view header, std::string_view key) {
    const size_t place = header.find(key);
    if (place == std::string_view::npos) return {};
    const size_t begin = header.find_first_not_of(" :", place + key.size());
    return begin == std::string_view::npos ? std::string_view{} : header.substr(begin);
}

template <class T>
void convert(std::span<const uint8_t> data, std::vector<double>& values) {
    for (size_t i = 0; i < values.size(); ++i) values[i] = double(at<T>(data, i * sizeof(T)));
}

}  // namespace

Result<NpyArray> parseNpy(std::span<const uint8_t> bytes) {
    constexpr uint8_t kMagic[] = {0x93, 'N', 'U', 'M', 'P', 'Y'};
    Reader in(bytes);
    DPL_TRY(const auto magic, in.take(6));
    if (std::memcmp(magic.data(), kMagic, 6) != 0) return fail(Code::CorruptData, "not a .npy array");
    DPL_TRY(const uint8_t major, in.value<uint8_t>());
    DPL_CHECK_OK(in.skip(1));
    size_t headerBytes = 0;
    if (major == 1) {
        DPL_TRY(headerBytes, in.value<uint16_t>());
    } else if (major <= 3) {
        DPL_TRY(headerBytes, in.u32());
    } else {
        return fail(Code::Version, ".npy version {}", int(major));
    }
    DPL_TRY(const auto headerRaw, in.take(headerBytes));
    const std::string_view header(reinterpret_cast<const char*>(headerRaw.data()), headerRaw.size());

    const std::string_view descr = valueOf(header, "'descr'"), order = valueOf(header, "'fortran_order'");
    std::string_view shapeText = valueOf(header, "'shape'");
    if (descr.size() < 5 || (descr[0] != '\'' && descr[0] != '"') || shapeText.empty() || shapeText[0] != '(')
        return fail(Code::CorruptData, "the .npy header cannot be read");
    const std::string type(descr.substr(1, 3));
    if (type[1] == 'O') return fail(Code::Unsupported, "a Python object array; save the numbers alone");
    if (order.substr(0, 4) == "True") return fail(Code::Unsupported, "an array in Fortran order; save it with np.ascontiguousarray");
    const size_t itemBytes = type[2] >= '1' && type[2] <= '8' ? size_t(type[2] - '0') : 0;

    NpyArray array;
    size_t count = 1;
    shapeText = shapeText.substr(1, shapeText.find(')') == std::string_view::npos ? 0 : shapeText.find(')') - 1);
    while (!shapeText.empty()) {
        const size_t digit = shapeText.find_first_of("0123456789");
        if (digit == std::string_view::npos) break;
        size_t extent = 0;
        const auto [end, error] = std::from_chars(shapeText.data() + digit, shapeText.data() + shapeText.size(), extent);
        if (error != std::errc() || array.shape.size() == 8) return fail(Code::CorruptData, "the .npy shape cannot be read");
        if (extent != 0 && count > SIZE_MAX / 16 / extent) return fail(Code::CorruptData, "the .npy shape is too large");
        count *= extent;
        array.shape.push_back(extent);
        shapeText = shapeText.substr(size_t(end - shapeText.data()));
    }
    if (itemBytes == 0 || count > in.remaining() / itemBytes)
        return fail(Code::CorruptData, "{} values of type {} wanted, {} bytes left", count, type, in.remaining());
    DPL_TRY(const auto data, in.take(count * itemBytes));
    array.values.resize(count);
    if (type == "<f4")
        convert<float>(data, array.values);
    else if (type == "<f8")
        convert<double>(data, array.values);
    else if (type == "<i4")
        convert<int32_t>(data, array.values);
    else if (type == "<i8")
        convert<int64_t>(data, array.values);
    else if (type == "<u4")
        convert<uint32_t>(data, array.values);
    else if (type == "<u8")
        convert<uint64_t>(data, array.values);
    else if (type == "<i2")
        convert<int16_t>(data, array.values);
    else if (type == "<u2")
        convert<uint16_t>(data, array.values);
    else
        return fail(Code::Unsupported, "arrays of type '{}' are not read", type);
    return array;
}

Result<NpzFile> NpzFile::open(std::span<const uint8_t> bytes) {
    if (bytes.size() < kDirectoryEndBytes) return fail(Code::CorruptData, "too short to be an .npz archive");
    size_t end = bytes.size() - kDirectoryEndBytes;
    const size_t lowest = end > kMaxCommentBytes ? end - kMaxCommentBytes : 0;
    while (at<uint32_t>(bytes, end) != kDirectoryEnd) {
        if (end == lowest) return fail(Code::CorruptData, "not an .npz archive, or cut short: it has no zip directory");
        --end;
    }
    const uint16_t entryCount = at<uint16_t>(bytes, end + 10);
    const uint32_t directoryOffset = at<uint32_t>(bytes, end + 16);
    if (directoryOffset > end) return fail(Code::CorruptData, "the zip directory lies outside the file");
    Reader directory(bytes.subspan(directoryOffset, end - directoryOffset));
    NpzFile file;
    for (uint16_t i = 0; i < entryCount; ++i) {
        DPL_TRY(const auto e, directory.take(46));
        if (at<uint32_t>(e, 0) != kDirectoryEntry) return fail(Code::CorruptData, "entry {} of the zip directory is damaged", i);
        const uint16_t flags = at<uint16_t>(e, 8), method = at<uint16_t>(e, 10);
        const uint32_t stored = at<uint32_t>(e, 20), plain = at<uint32_t>(e, 24), offset = at<uint32_t>(e, 42);
        DPL_TRY(const auto nameRaw, directory.take(at<uint16_t>(e, 28)));
        DPL_CHECK_OK(directory.skip(size_t(at<uint16_t>(e, 30)) + at<uint16_t>(e, 32)));
        std::string name(nameRaw.begin(), nameRaw.end());
        if (name.size() > 4 && name.ends_with(".npy")) name.resize(name.size() - 4);
        if ((flags & 1) || (method != 0 && method != 8) || stored == UINT32_MAX || plain == UINT32_MAX || offset == UINT32_MAX)
            return fail(Code::Unsupported,
                        "'{}' is encrypted, zip64 or compressed in a way we do not read; save it with np.savez or np.savez_compressed",
                        name);
        // Skip the local header's own name and extra field: their lengths may differ from the directory's.
        if (offset > bytes.size() || bytes.size() - offset < 30 || at<uint32_t>(bytes, offset) != kLocalHeader)
            return fail(Code::CorruptData, "'{}' lies outside the file", name);
        const uint64_t begin = uint64_t(offset) + 30 + at<uint16_t>(bytes, offset + 26) + at<uint16_t>(bytes, offset + 28);
        if (begin > bytes.size() || stored > bytes.size() - begin) return fail(Code::CorruptData, "'{}' is cut short", name);
        file.entries_[name] = {bytes.subspan(size_t(begin), stored), plain, method == 8};
    }
    return file;
}

Result<NpyArray> NpzFile::read(const std::string& name, size_t maxBytes) const {
    const auto entry = entries_.find(name);
    if (entry == entries_.end()) return fail(Code::NotFound, "array '{}' is missing", name);
    const Entry& e = entry->second;
    if (e.plainBytes > maxBytes) return fail(Code::Unsupported, "array '{}' has {} bytes, the limit is {}", name, e.plainBytes, maxBytes);
    std::vector<uint8_t> unpacked;
    std::span<const uint8_t> bytes = e.stored;
    if (e.deflated) {
        auto plain = inflateBytes(e.stored, DeflateWrapper::Raw, maxBytes);
        if (!plain) return fail(plain.error().code, "array '{}': {}", name, plain.error().message);
        unpacked = std::move(*plain);
        bytes = unpacked;
    }
    auto array = parseNpy(bytes);
    if (!array) return fail(array.error().code, "array '{}': {}", name, array.error().message);
    return array;
}

}  // namespace dpl
