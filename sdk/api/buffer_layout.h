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

struct BufferColumn {
    uint32_t property = 0;
    StridedNumbers to;
};

struct BufferColumns {
    std::array<BufferColumn, DPL_MAX_BUFFER_ELEMENTS> columns;
    uint32_t count = 0;
    std::span<const BufferColumn> all() const { return {columns.data(), count}; }
};

/** Where the elements of `count` splats or vertices go. InvalidArgument: an unknown property or number, rows that overlap, or that do not
 *  fit into the buffer. */
Result<BufferColumns> columnsOf(const DplBuffer* buffer, std::span<const BufferProperty> known, uint64_t count);

}  // namespace dpl::api
