// SPDX-License-Identifier: Apache-2.0
// Checks a buffer that a program has laid out, before anything is written to it.
#pragma once

#include <array>
#include <span>

#include "sdk/api/api_state.h"
#include "sdk/math/strided_numbers.h"

namespace dpl::api {

/** A property of a splat or a vertex, by its number in the API. */
struct BufferProperty {
    const char* name;
    uint32_t numbers;
};

/** Rows of one property: where the first one lies, and the bytes from row to row and of a row. */
struct BufferRows {
    uint32_t property = 0;
    const char* name = "";
    bool half = false;
    uint64_t offset = 0, stride = 0, bytes = 0;
    uint64_t end(uint64_t count) const { return offset + (count - 1) * stride + bytes; }
};

struct BufferLayout {
    std::array<BufferRows, DPL_MAX_BUFFER_ELEMENTS> rows;
    uint32_t count = 0;
    std::span<const BufferRows> all() const { return {rows.data(), count}; }
};

/** Who writes the rows: a GPU stores whole words of four bytes. */
enum class RowWriter : uint8_t { Cpu, Gpu };

/** The elements of a buffer for `count` splats or vertices. InvalidArgument: no elements or too many, an unknown property or number, rows
 *  that overlap, that do not fit into the buffer, or that begin within a word of a GPU's. */
Result<BufferLayout> layoutOf(const DplBufferElement* elements, uint32_t elementCount, uint64_t dataBytes,
                              std::span<const BufferProperty> known, uint64_t count, RowWriter writer);

struct BufferColumn {
    uint32_t property = 0;
    StridedNumbers to;
};

struct BufferColumns {
    std::array<BufferColumn, DPL_MAX_BUFFER_ELEMENTS> columns;
    uint32_t count = 0;
    std::span<const BufferColumn> all() const { return {columns.data(), count}; }
};

/** Where the elements of `count` splats or vertices go in memory. Errors as of layoutOf(). */
Result<BufferColumns> columnsOf(const DplBuffer* buffer, std::span<const BufferProperty> known, uint64_t count);

}  // namespace dpl::api
