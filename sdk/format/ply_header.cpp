// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>

#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr size_t kMaxHeaderBytes = 64 * 1024;
constexpr uint32_t kMostFileShDegree = 8;  // read, not drawn: far above what programs write

std::optional<PlyType> typeOf(std::string_view name) {
    static const std::map<std::string_view, PlyType> types = {
        {"char", PlyType::I8},   {"int8", PlyType::I8},     {"uchar", PlyType::U8},   {"uint8", PlyType::U8},
        {"short", PlyType::I16}, {"int16", PlyType::I16},   {"ushort", PlyType::U16}, {"uint16", PlyType::U16},
        {"int", PlyType::I32},   {"int32", PlyType::I32},   {"uint", PlyType::U32},   {"uint32", PlyType::U32},
        {"float", PlyType::F32}, {"float32", PlyType::F32}, {"double", PlyType::F64}, {"float64", PlyType::F64}};
    const auto it = types.find(name);
    if (it == types.end()) return std::nullopt;
    return it->second;
}

constexpr std::array<size_t, 8> kTypeBytes = {1, 1, 2, 2, 4, 4, 4, 8};
constexpr std::array<const char*, 8> kTypeNames = {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};

std::vector<std::string_view> words(std::string_view line) {
    std::vector<std::string_view> out;
    while (true) {
        const size_t from = line.find_first_not_of(" \t\r");
        if (from == std::string_view::npos) return out;
        const size_t end = std::min(line.find_first_of(" \t\r", from), line.size());
        out.push_back(line.substr(from, end - from));
        line.remove_prefix(end);
    }
}

Result<uint64_t> countOf(std::string_view text) {
    uint64_t value = 0;
    for (char c : text) {
        if (c < '0' || c > '9' || value > (1ull << 40)) return fail(Code::CorruptData, "PLY: a count of '{}'", text.substr(0, 32));
        value = value * 10 + uint64_t(c - '0');
    }
    return value;
}

}  // namespace

const PlyElement* PlyHeader::find(std::string_view name) const {
    const auto it = std::find_if(elements.begin(), elements.end(), [&](const PlyElement& e) { return e.name == name; });
    return it == elements.end() ? nullptr : &*it;
}

Result<PlyHeader> readPlyHeader(std::span<const uint8_t> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kMaxHeaderBytes));
    if (!text.starts_with("ply\n") && !text.starts_with("ply\r\n"))
        return fail(Code::Unsupported, "not a PLY file: it does not begin with 'ply'");
    PlyHeader header;
    bool binary = false;
    for (size_t at = 0; at < text.size();) {
        const size_t end = text.find('\n', at);
        if (end == std::string_view::npos) break;
        const std::string_view whole = text.substr(at, end - at);
        const auto line = words(whole);
        at = end + 1;
        if (line.empty() || line[0] == "obj_info" || line[0] == "ply") continue;
        if (line[0] == "comment") {
            if (line.size() > 1) header.comments.emplace_back(line[1].data(), whole.data() + whole.size());
            continue;
        }
        if (line[0] == "format") {
            binary = line.size() >= 2 && line[1] == "binary_little_endian";
        } else if (line[0] == "element" && line.size() == 3) {
            PlyElement& element = header.elements.emplace_back();
            element.name = line[1];
            DPL_TRY(element.count, countOf(line[2]));
        } else if (line[0] == "property" && !header.elements.empty()) {
            PlyElement& element = header.elements.back();
            const auto type = line.size() == 3 ? typeOf(line[1]) : std::nullopt;
            if (!type) {
                for (const std::string_view word : line)
                    element.unread += std::string(element.unread.empty() ? "" : " ") + std::string(word);
                continue;
            }
            element.columns[std::string(line[2])] = {element.stride, *type};
            element.stride += kTypeBytes[size_t(*type)];
        } else if (line[0] == "end_header") {
            if (!binary) return fail(Code::Unsupported, "PLY: only binary_little_endian is read; save it as binary");
            header.bodyAt = at;
            return header;
        }
    }
    return fail(Code::CorruptData, "PLY: no end_header in the first {} bytes", text.size());
}

Result<PlyRows> plyRows(const PlyHeader& header, std::span<const uint8_t> bytes, std::string_view name, uint64_t limit) {
    size_t at = header.bodyAt;
    for (const PlyElement& e : header.elements) {
        if (e.unread.starts_with("property list"))
            return fail(Code::Unsupported, "PLY: element '{}' has a property that is a list; is this a mesh?", e.name);
        if (!e.unread.empty())
            return fail(Code::Unsupported, "PLY: element '{}' has a property of unknown type{}; save the file with 32-bit floats", e.name,
                        e.unread.substr(8, 64));
        const size_t left = bytes.size() - at;
        if (e.stride != 0 && e.count > left / e.stride)
            return fail(Code::CorruptData, "PLY: {} rows of {} bytes of '{}' do not fit in {} bytes: truncated", e.count, e.stride, e.name,
                        left);
        if (e.name == name) {
            if (e.stride == 0 && e.count != 0) return fail(Code::CorruptData, "PLY: element '{}' has no properties", e.name);
            if (e.count > limit) return fail(Code::CorruptData, "PLY: {} rows of '{}', the limit is {}", e.count, e.name, limit);
            return PlyRows{&e, bytes.data() + at, size_t(e.count)};
        }
        at += size_t(e.count) * e.stride;
    }
    return fail(Code::CorruptData, "PLY: there is no element '{}'; is this a Gaussian splat file?", name);
}

Result<size_t> plyColumn(const PlyRows& rows, PlyType type, const std::string& name) {
    const auto& columns = rows.element->columns;
    const auto it = columns.find(name);
    if (it == columns.end())
        return fail(
            Code::CorruptData, "PLY: element '{}' has no {} property '{}'; {}", rows.element->name, kTypeNames[size_t(type)], name,
            columns.contains("red") ? "it has 'red': this is a point cloud, not Gaussian splats" : "is this a Gaussian splat file?");
    if (it->second.type != type)
        return fail(Code::Unsupported, "PLY: property '{}' of element '{}' is a {}, and only {} is read; save the file with {} values",
                    name, rows.element->name, kTypeNames[size_t(it->second.type)], kTypeNames[size_t(type)],
                    type == PlyType::F32 ? "32-bit float" : kTypeNames[size_t(type)]);
    return it->second.offset;
}

Result<std::vector<size_t>> plyColumns(const PlyRows& rows, PlyType type, std::initializer_list<const char*> names) {
    std::vector<size_t> out;
    for (const char* name : names) {
        DPL_TRY(const size_t at, plyColumn(rows, type, name));
        out.push_back(at);
    }
    return out;
}

Result<std::vector<size_t>> plyRestColumns(const PlyRows& rows, PlyType type, uint32_t& shDegree) {
    std::vector<size_t> rest;
    while (rows.element->columns.contains("f_rest_" + std::to_string(rest.size()))) {
        DPL_TRY(const size_t at, plyColumn(rows, type, "f_rest_" + std::to_string(rest.size())));
        rest.push_back(at);
    }
    shDegree = 0;
    while (shDegree < kMostFileShDegree && (shCoefficientCount(shDegree) - 1) * 3 < rest.size()) ++shDegree;
    if ((shCoefficientCount(shDegree) - 1) * 3 != rest.size())
        return fail(Code::CorruptData, "PLY: {} f_rest properties; 0, 9, 24, 45 or 72 are possible (SH degrees 0 to 4)", rest.size());
    return rest;
}

}  // namespace dpl
