// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/npz.h"

#include <charconv>
#include <cstring>
#include <string_view>

#include "reconstruction/base/value_at.h"
#include "sdk/core/reader.h"

namespace dpl {
namespace {

constexpr size_t kMemoryFactor = 64, kMemoryBase = size_t(64) << 20;  // promised in npz.h

/** The text after `key` in a header such as {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }. */
std::string_view valueOf(std::string_view header, std::string_view key) {
    const size_t place = header.find(key);
    if (place == std::string_view::npos) return {};
    const size_t begin = header.find_first_not_of(" :", place + key.size());
    return begin == std::string_view::npos ? std::string_view{} : header.substr(begin);
}

template <class T>
void convert(std::span<const uint8_t> data, std::vector<double>& values) {
    for (size_t i = 0; i < values.size(); ++i) values[i] = double(valueAt<T>(data, i * sizeof(T)));
}

}  // namespace

Result<NpyArray> parseNpy(std::span<const uint8_t> bytes, size_t maxValues) {
    constexpr uint8_t kMagic[] = {0x93, 'N', 'U', 'M', 'P', 'Y'};
    Reader in(bytes);
    DPL_TRY(const auto magic, in.take(6));
    if (std::memcmp(magic.data(), kMagic, 6) != 0) return fail(Code::CorruptData, "not a .npy array");
    DPL_TRY(const uint8_t major, in.value<uint8_t>());
    DPL_RETURN_IF_ERROR(in.skip(1));
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
    if (count > maxValues) return fail(Code::Unsupported, "{} values, at most {} are read", count, maxValues);
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
    auto zip = ZipFile::open(bytes);
    if (!zip) return fail(zip.error().code, "not an .npz archive that we read: {}; save it with np.savez", zip.error().message);
    NpzFile file;
    file.zip_ = std::move(*zip);
    file.budgetBytes_ = kMemoryFactor * bytes.size() + kMemoryBase;
    return file;
}

Result<NpyArray> NpzFile::read(const std::string& name) {
    const std::string entry = zip_.has(name + ".npy") ? name + ".npy" : name;
    if (!zip_.has(entry)) return fail(Code::NotFound, "array '{}' is missing", name);
    const size_t plain = zip_.plainBytes(entry);
    const auto tooLarge = [&] {
        return fail(Code::Unsupported, "array '{}' unpacks to {} bytes, which is more than an archive of this size may hold", name, plain);
    };
    if (plain > budgetBytes_) return tooLarge();
    DPL_TRY(const auto bytes, zip_.read(entry, budgetBytes_));
    auto array = parseNpy(bytes, (budgetBytes_ - plain) / sizeof(double));
    if (!array) return fail(array.error().code, "array '{}': {}", name, array.error().message);
    budgetBytes_ -= array->values.size() * sizeof(double);
    return array;
}

}  // namespace dpl
