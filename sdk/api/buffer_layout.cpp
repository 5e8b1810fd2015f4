// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/buffer_layout.h"

namespace dpl::api {
namespace {

constexpr uint64_t kWordBytes = 4;  // of a GPU

Result<BufferRows> rowsOf(const DplBufferElement& element, uint32_t index, std::span<const BufferProperty> known, RowWriter writer) {
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
    const uint64_t stride = element.strideBytes == 0 ? bytes : element.strideBytes;
    if (writer == RowWriter::Gpu && (element.offsetBytes % kWordBytes != 0 || stride % kWordBytes != 0))
        return fail(Code::InvalidArgument,
                    "{} (element {}) begins at byte {}, with {} bytes from row to row; on a GPU both must be multiples of {}",
                    property.name, index, element.offsetBytes, stride, kWordBytes);
    return BufferRows{element.property, property.name, element.number == DPL_NUMBER_HALF, element.offsetBytes, stride, bytes};
}

Status checkFits(const BufferRows& rows, uint32_t index, uint64_t count, uint64_t dataBytes, RowWriter writer) {
    const uint64_t touched = writer == RowWriter::Gpu ? (rows.bytes + kWordBytes - 1) / kWordBytes * kWordBytes : rows.bytes;
    const bool fits = touched <= dataBytes && rows.offset <= dataBytes - touched &&
                      (count == 1 || rows.stride <= (dataBytes - touched - rows.offset) / (count - 1));
    if (fits) return {};
    return fail(Code::InvalidArgument,
                "{} (element {}) does not fit: {} rows of {} bytes, {} apart, from byte {} on do not lie within the buffer's {} bytes",
                rows.name, index, count, touched, rows.stride, rows.offset, dataBytes);
}

/** Both lie within the buffer. */
bool overlap(const BufferRows& a, const BufferRows& b, uint64_t count) {
    if (a.offset > b.offset) return overlap(b, a, count);
    if (b.offset >= a.end(count)) return false;
    if (a.stride != b.stride) return true;
    const uint64_t shift = (b.offset - a.offset) % a.stride;  // of b's rows within the rows of a
    return shift < a.bytes || shift + b.bytes > a.stride;
}

}  // namespace

Result<BufferLayout> layoutOf(const DplBufferElement* elements, uint32_t elementCount, uint64_t dataBytes,
                              std::span<const BufferProperty> known, uint64_t count, RowWriter writer) {
    if (elementCount == 0 || elementCount > DPL_MAX_BUFFER_ELEMENTS)
        return fail(Code::InvalidArgument, "the buffer has {} elements; 1 to {} are possible", elementCount, DPL_MAX_BUFFER_ELEMENTS);
    BufferLayout out;
    out.count = elementCount;
    auto& rows = out.rows;
    for (uint32_t i = 0; i < elementCount; ++i) {
        DPL_TRY(const DplBufferElement one, element<DplBufferElement>(elements, i, "elements"));
        DPL_TRY(rows[i], rowsOf(one, i, known, writer));
        if (count > 0) DPL_RETURN_IF_ERROR(checkFits(rows[i], i, count, dataBytes, writer));
        for (uint32_t k = 0; k < i && count > 0; ++k)
            if (overlap(rows[k], rows[i], count))
                return fail(Code::InvalidArgument,
                            "{} (element {}) and {} (element {}) overlap, or share a range with different strides ({} and {} bytes)",
                            rows[k].name, k, rows[i].name, i, rows[k].stride, rows[i].stride);
    }
    return out;
}

Result<BufferColumns> columnsOf(const DplBuffer* given, std::span<const BufferProperty> known, uint64_t count) {
    DPL_TRY(const DplBuffer buffer, readStruct<DplBuffer>(given, "buffer"));
    if (buffer.data == nullptr) return fail(Code::InvalidArgument, "data of the buffer is NULL");
    DPL_TRY(const BufferLayout layout, layoutOf(buffer.elements, buffer.elementCount, buffer.dataBytes, known, count, RowWriter::Cpu));
    BufferColumns out;
    out.count = layout.count;
    for (uint32_t i = 0; i < layout.count; ++i) {
        const BufferRows& rows = layout.rows[i];
        out.columns[i] = {rows.property, {static_cast<uint8_t*>(buffer.data) + rows.offset, size_t(rows.stride), rows.half}};
    }
    return out;
}

}  // namespace dpl::api
