// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/json_fields.h"

#include <algorithm>
#include <cmath>
#include <fstream>

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {
constexpr size_t kMaxNameBytes = 128;
}

Result<json> parseJsonObject(std::string_view text, const std::string& where) {
    json value;
    try {
        // The callback limits nesting, because later code may recurse over the value.
        value = json::parse(text, [](int depth, json::parse_event_t, json&) {
            if (depth > 64) throw std::runtime_error("nested deeper than 64 levels");
            return true;
        });
    } catch (const std::exception& e) {
        return fail(Code::CorruptData, "{}: not valid JSON ({}); write the file again", where, e.what());
    }
    if (!value.is_object()) return fail(Code::CorruptData, "{}: a JSON object is expected at the top; write the file again", where);
    return value;
}

Result<json> readJsonObject(const fs::path& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return fail(Code::NotFound, "{}: not found; restore the file", path.string());
    const auto bytes = fs::file_size(path, error);
    if (error) return fail(Code::Io, "{}: {}; check its permissions", path.string(), error.message());
    if (bytes > kMaxJsonBytes)
        return fail(Code::Unsupported, "{}: {} bytes of JSON, at most {} are read; split the scan", path.string(), bytes, kMaxJsonBytes);
    std::string text(bytes, '\0');
    std::ifstream in(path, std::ios::binary);
    if (!in.read(text.data(), std::streamsize(bytes))) return fail(Code::Io, "{}: cannot be read; check its permissions", path.string());
    return parseJsonObject(text, path.string());
}

Result<fs::path> fileInside(const fs::path& root, const std::string& relative, std::string_view where) {
    const fs::path path(relative);
    bool escapes = relative.empty() || relative.size() > 1024 || relative.find('\0') != std::string::npos || path.is_absolute() ||
                   relative.find('\\') != std::string::npos;
    for (const auto& part : path) escapes = escapes || part == "..";
    if (escapes)
        return fail(Code::CorruptData, "{}: the path '{}' is not allowed; paths must be relative to the scan folder and stay inside it",
                    where, relative.substr(0, 200));
    const fs::path whole = (root / path).lexically_normal();
    std::error_code error;
    if (!fs::exists(whole, error))
        return fail(Code::NotFound, "{}: {} is missing; restore the file or remove the entry", where, whole.string());
    if (!fs::is_regular_file(whole, error))
        return fail(Code::CorruptData, "{}: {} is not a file; restore it or remove the entry", where, whole.string());
    return whole;
}

namespace {

bool isPlain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
}

/** Bytes of the character at the start of `text` if it can stand in a name: plain ASCII, or well-formed UTF-8 from U+00A0 on that neither
 *  breaks lines nor turns the direction of writing. 0: it cannot. */
size_t nameCharacterBytes(std::string_view text) {
    const auto byte = [&](size_t i) { return uint32_t(static_cast<unsigned char>(text[i])); };
    if (byte(0) < 0x80) return isPlain(text[0]) ? 1 : 0;
    const size_t count = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
    if (byte(0) < 0xc2 || byte(0) > 0xf4 || count > text.size()) return 0;
    uint32_t code = byte(0) & (0xffu >> (count + 1));
    for (size_t i = 1; i < count; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(i) & 0x3f);
    }
    constexpr uint32_t kSmallest[] = {0, 0, 0xa0, 0x800, 0x10000};
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    const bool layout = (code >= 0x200b && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return code < kSmallest[count] || code > 0x10ffff || surrogate || layout || code == 0xfeff ? 0 : count;
}

}  // namespace

bool isSafeName(std::string_view name) {
    if (name.empty() || name.size() > kMaxNameBytes || name.front() == '.') return false;
    while (!name.empty()) {
        const size_t bytes = nameCharacterBytes(name);
        if (bytes == 0) return false;
        name.remove_prefix(bytes);
    }
    return true;
}

std::string withSlashes(std::string path) {
    std::replace(path.begin(), path.end(), '\\', '/');
    return path;
}

std::string nameFromPath(std::string_view relativePath) {
    const std::string whole = withSlashes(std::string(relativePath));
    std::string_view left = whole;
    for (const std::string_view prefix : {"./", "images/"})
        if (left.starts_with(prefix)) left.remove_prefix(prefix.size());
    const size_t slash = left.find_last_of('/'), dot = left.find_last_of('.');
    if (dot != std::string_view::npos && dot > 0 && (slash == std::string_view::npos || dot > slash + 1)) left = left.substr(0, dot);
    std::string name;
    while (!left.empty()) {
        const size_t bytes = nameCharacterBytes(left), taken = std::max<size_t>(bytes, 1);
        if (name.size() + taken > kMaxNameBytes) break;
        name += bytes > 0 ? left.substr(0, bytes) : "_";
        left.remove_prefix(taken);
    }
    if (!name.empty() && name.front() == '.') name.front() = '_';
    return name;
}

std::string numberedName(const std::string& name, size_t number) {
    const std::string suffix = formatText("_{}", number);
    size_t end = std::min(name.size(), kMaxNameBytes - suffix.size());
    while (end > 0 && end < name.size() && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // not inside a character
    return name.substr(0, end) + suffix;
}

bool JsonFields::has(const char* key) const {
    const auto found = object_.find(key);
    return found != object_.end() && !found->is_null();
}

bool JsonFields::states(const char* key) const {
    if (!has(key)) return false;
    const json& value = object_.at(key);
    if (value.is_boolean()) return value.get<bool>();
    if (value.is_number()) return value.get<double>() != 0;
    return !value.is_string() || (value != "" && value != "0" && value != "false" && value != "False");
}

Result<double> JsonFields::number(const char* key) const {
    if (!object_.contains(key)) return fail(Code::CorruptData, "{}: '{}' is missing; add the number", where_, key);
    const json& value = object_.at(key);
    if (value.is_null())  // what JavaScript writes for a number that is not finite
        return fail(Code::CorruptData, "{}: '{}' is null, not a finite number; write the number, or remove the field", where_, key);
    if (!value.is_number() || !std::isfinite(value.get<double>()))
        return fail(Code::CorruptData, "{}: '{}' is not a finite number; correct it", where_, key);
    return value.get<double>();
}

Result<double> JsonFields::number(const char* key, double otherwise) const {
    if (!object_.contains(key)) return otherwise;
    return number(key);
}

Result<std::string> JsonFields::text(const char* key) const {
    if (!has(key)) return fail(Code::CorruptData, "{}: '{}' is missing; add it", where_, key);
    const json& value = object_.at(key);
    if (!value.is_string()) return fail(Code::CorruptData, "{}: '{}' is not text; correct it", where_, key);
    return value.get<std::string>();
}

Result<std::string> JsonFields::text(const char* key, const std::string& otherwise) const {
    if (!has(key)) return otherwise;
    return text(key);
}

Result<bool> JsonFields::boolean(const char* key, bool otherwise) const {
    if (!has(key)) return otherwise;
    const json& value = object_.at(key);
    if (!value.is_boolean()) return fail(Code::CorruptData, "{}: '{}' is neither true nor false; correct it", where_, key);
    return value.get<bool>();
}

Result<const json*> JsonFields::array(const char* key) const {
    if (!has(key)) return fail(Code::CorruptData, "{}: '{}' is missing; add the list", where_, key);
    const json& value = object_.at(key);
    if (!value.is_array()) return fail(Code::CorruptData, "{}: '{}' is not a list; correct it", where_, key);
    return &value;
}

Result<std::vector<double>> JsonFields::numbers(const char* key, size_t count) const {
    DPL_TRY(const json* list, array(key));
    std::vector<double> numbers;
    if (list->size() != count)
        return fail(Code::CorruptData, "{}: '{}' has {} numbers, {} are needed; correct it", where_, key, list->size(), count);
    for (const json& value : *list) {
        if (!value.is_number() || !std::isfinite(value.get<double>()))
            return fail(Code::CorruptData, "{}: '{}' holds something that is not a finite number; correct it", where_, key);
        numbers.push_back(value.get<double>());
    }
    return numbers;
}

}  // namespace dpl
