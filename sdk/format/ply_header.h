// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file and the place of its elements, for all PLY readers. Internal.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

enum class PlyType : uint8_t { I8, U8, I16, U16, I32, U32, F32, F64 };

struct PlyElement {
    struct Column {
        size_t offset = 0;
        PlyType type = PlyType::F32;
    };
    std::string name;
    uint64_t count = 0;
    size_t stride = 0;
    std::string unread;  // words of a property that is a list or of unknown type: neither its rows nor later elements can be found
    std::map<std::string, Column, std::less<>> columns;
};

struct PlyHeader {
    std::vector<PlyElement> elements;   // in file order
    std::vector<std::string> comments;  // without the word "comment"; in file order
    size_t bodyAt = 0;

    const PlyElement* find(std::string_view name) const;
};

/** The rows of one element; all lie inside the file. Borrows the header and the bytes. */
struct PlyRows {
    const PlyElement* element = nullptr;
    const uint8_t* first = nullptr;
    size_t count = 0;

    const uint8_t* row(size_t i) const { return first + i * element->stride; }
};

/** Reads the header, at most 64 KiB, of a binary little-endian file. Unsupported: any other file, also an ASCII PLY. */
Result<PlyHeader> readPlyHeader(std::span<const uint8_t> bytes);

/** CorruptData if the element is absent, longer than the file or has more than `limit` rows. */
Result<PlyRows> plyRows(const PlyHeader& header, std::span<const uint8_t> bytes, std::string_view element, uint64_t limit);

/** Byte offsets within a row of columns that must have this type. CorruptData names a column that is missing, Unsupported one of another
 *  type. */
Result<size_t> plyColumn(const PlyRows& rows, PlyType type, const std::string& name);
Result<std::vector<size_t>> plyColumns(const PlyRows& rows, PlyType type, std::initializer_list<const char*> names);

/** Offsets of the columns f_rest_0, f_rest_1 ...: all reds, then all greens, then all blues. Their number (0, 9, 24, 45, 72 ...) gives the
 *  SH degree, which may be above kMaxShDegree. */
Result<std::vector<size_t>> plyRestColumns(const PlyRows& rows, PlyType type, uint32_t& shDegree);

}  // namespace dpl
