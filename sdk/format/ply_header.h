// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file and where the rows of its elements lie: what all PLY readers share. Internal.
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
    bool hasList = false;  // rows of unknown length: neither it nor what follows can be found
    std::map<std::string, Column, std::less<>> columns;
};

struct PlyHeader {
    std::vector<PlyElement> elements;  // in file order
    size_t bodyAt = 0;

    const PlyElement* find(std::string_view name) const;
};

/** Rows of one element, all inside the file. Borrows the header and the bytes. */
struct PlyRows {
    const PlyElement* element = nullptr;
    const uint8_t* first = nullptr;
    size_t count = 0;

    const uint8_t* row(size_t i) const { return first + i * element->stride; }
};

/** Binary little-endian files only, a header of at most 64 KiB. Unsupported: other bytes or an ASCII file. */
Result<PlyHeader> readPlyHeader(std::span<const uint8_t> bytes);

/** CorruptData when the element is absent, longer than the file or above `limit` rows. */
Result<PlyRows> plyRows(const PlyHeader& header, std::span<const uint8_t> bytes, std::string_view element, uint64_t limit);

/** Offsets in a row of columns that must be there with this type. CorruptData names what is missing. */
Result<size_t> plyColumn(const PlyRows& rows, PlyType type, const std::string& name);
Result<std::vector<size_t>> plyColumns(const PlyRows& rows, PlyType type, std::initializer_list<const char*> names);

/** f_rest_0 and on: none, 9, 24 or 45 of them, and so the SH degree. They are all reds, then all greens, then all blues. */
Result<std::vector<size_t>> plyRestColumns(const PlyRows& rows, PlyType type, uint32_t& shDegree);

}  // namespace dpl
