// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/json_fields.h"

#include <cmath>
#include <fstream>

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

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

bool isSafeName(std::string_view name) {
    if (name.empty() || name.size() > 128 || name.front() == '.') return false;
    for (const char c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
        if (!plain) return false;
    }
    return true;
}

std::string nameFromPath(std::string_view relativePath) {
    std::string name(relativePath);
    for (const char* prefix : {"./", "images/"})
        if (name.starts_with(prefix)) name.erase(0, std::string_view(prefix).size());
    const size_t slash = name.find_last_of('/'), dot = name.find_last_of('.');
    if (dot != std::string::npos && dot > 0 && (slash == std::string::npos || dot > slash + 1)) name.erase(dot);
    for (char& c : name)
        if (!isSafeName({&c, 1}) && c != '.') c = '_';
    if (!name.empty() && name.front() == '.') name.front() = '_';
    return name.substr(0, 128);
}

bool JsonFields::has(const char* key) const {
    const auto found = object_.find(key);
    return found != object_.end() && !found->is_null();
}

Result<double> JsonFields::number(const char* key) const {
    if (!has(key)) return fail(Code::CorruptData, "{}: '{}' is missing; add the number", where_, key);
    const json& value = object_.at(key);
    if (!value.is_number() || !std::isfinite(value.get<double>()))
        return fail(Code::CorruptData, "{}: '{}' is not a finite number; correct it", where_, key);
    return value.get<double>();
}

Result<double> JsonFields::number(const char* key, double otherwise) const {
    if (!has(key)) return otherwise;
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
