// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/buffer_layout.h"

namespace dpl::api {
namespace {

struct Rows {
    const char* name;
    uint64_t offset, stride, bytes;  // of the first row; from row to row; of a row
    uint64_t end(uint64_t count) const { return offset + (count - 1) * stride + bytes; }
};

Result<Rows> rowsOf(const DplBufferElement& element, uint32_t index, std::span<const BufferProperty> known) {
    if (element.property >= known.size())
        return fail(Code::InvalidArgument, "element {} is of property {}, which does not exist; the last one is {} ({})", index,
                    element.property, known.size() - 1, known.back().name);
    const BufferProperty& property = known[element.property];
    if (element.number != DPL_NUMBER_FLOAT && element.number != DPL_NUMBER_HALF)
        return fail(Code::InvalidArgument, "{} (element {}) is of number {}; DPL_NUMBER_FLOAT and DPL_NUMBER_HALF exist", property.name,
                    index, int(element.number));
    const uint64_t bytes = uint64_t(property.numbers) * (element.number == DPL_NUMBER_HALF ? 2 : 4);
    if (element.strideBytes != 0 && element.strideBytes < bytes)
        return fail(Code::InvalidArgument, "{} (element {}) has a stride of {} bytes, but takes {}", property.name, index,
                    element.strideBytes, bytes);
    return Rows{property.name, element.offsetBytes, element.strideBytes == 0 ? bytes : element.strideBytes, bytes};
}

Status checkFits(const Rows& rows, uint32_t index, uint64_t count, uint64_t dataBytes) {
    const bool fits = rows.bytes <= dataBytes && rows.offset <= dataBytes - rows.bytes &&
                      (count == 1 || rows.stride <= (dataBytes - rows.bytes - rows.offset) / (count - 1));
    if (fits) return {};
    return fail(Code::InvalidArgument,
                "{} (element {}) does not fit: {} rows of {} bytes, {} apart, from byte {} on do not lie within the buffer's {} bytes",
                rows.name, index, count, rows.bytes, rows.stride, rows.offset, dataBytes);
}

/** Both lie within the buffer. */
bool overlap(const Rows& a, const Rows& b, uint64_t count) {
    if (a.offset > b.offset) return overlap(b, a, count);
    if (b.offset >= a.end(count)) return false;
    if (a.stride != b.stride) return true;
    const uint64_t shift = (b.offset - a.offset) % a.stride;  // of b's rows within the rows of a
    return shift < a.bytes || shift + b.bytes > a.stride;
}

}  // namespace

Result<BufferColumns> columnsOf(const DplBuffer* given, std::span<const BufferProperty> known, uint64_t count) {
    DPL_TRY(const DplBuffer buffer, readStruct<DplBuffer>(given, "buffer"));
    if (buffer.elementCount == 0 || buffer.elementCount > DPL_MAX_BUFFER_ELEMENTS)
        return fail(Code::InvalidArgument, "the buffer has {} elements; 1 to {} are possible", buffer.elementCount,
                    DPL_MAX_BUFFER_ELEMENTS);
    if (buffer.data == nullptr) return fail(Code::InvalidArgument, "data of the buffer is NULL");
    BufferColumns out;
    std::array<Rows, DPL_MAX_BUFFER_ELEMENTS> rows;
    for (uint32_t i = 0; i < buffer.elementCount; ++i) {
        DPL_TRY(const DplBufferElement one, element<DplBufferElement>(buffer.elements, i, "elements"));
        DPL_TRY(rows[i], rowsOf(one, i, known));
        if (count > 0) DPL_RETURN_IF_ERROR(checkFits(rows[i], i, count, buffer.dataBytes));
        for (uint32_t k = 0; k < i && count > 0; ++k)
            if (overlap(rows[k], rows[i], count))
                return fail(Code::InvalidArgument,
                            "{} (element {}) and {} (element {}) overlap, or share a range with different strides ({} and {} bytes)",
                            rows[k].name, k, rows[i].name, i, rows[k].stride, rows[i].stride);
        out.columns[i] = {one.property,
                          {static_cast<uint8_t*>(buffer.data) + rows[i].offset, size_t(rows[i].stride), one.number == DPL_NUMBER_HALF}};
    }
    out.count = buffer.elementCount;
    return out;
}

}  // namespace dpl::api
