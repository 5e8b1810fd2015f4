// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/inflate.h"

#include <zlib.h>

#include <algorithm>
#include <memory>

namespace dpl {

Result<std::vector<uint8_t>> inflateBytes(std::span<const uint8_t> compressed, DeflateWrapper wrapper, size_t maxBytes) {
    if (compressed.size() > UINT32_MAX)
        return fail(Code::Unsupported, "a compressed stream of {} bytes; the limit is 4 GiB", compressed.size());
    z_stream stream{};
    const int windowBits = wrapper == DeflateWrapper::Gzip ? 15 + 16 : -15;
    if (inflateInit2(&stream, windowBits) != Z_OK) return fail(Code::OutOfMemory, "zlib could not start");
    const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);
    stream.next_in = const_cast<Bytef*>(compressed.data());
    stream.avail_in = uInt(compressed.size());

    std::vector<uint8_t> out;
    constexpr size_t kMostPerByte = 1032;                                                                       // of deflate
    if (wrapper == DeflateWrapper::Raw && maxBytes / kMostPerByte <= compressed.size()) out.reserve(maxBytes);  // a zip states its size
    int status = Z_OK;
    while (status != Z_STREAM_END) {
        constexpr size_t kStepBytes = 1 << 20;
        const size_t used = out.size();
        if (used == maxBytes) return fail(Code::CorruptData, "the compressed data unpacks to more than {} bytes", maxBytes);
        out.resize(std::min(used + kStepBytes, maxBytes));
        stream.next_out = out.data() + used;
        stream.avail_out = uInt(out.size() - used);
        status = inflate(&stream, Z_NO_FLUSH);
        out.resize(out.size() - stream.avail_out);
        if (status == Z_STREAM_END) break;
        if (status != Z_OK) return fail(Code::CorruptData, "the compressed data is damaged or truncated");
    }
    return out;
}

}  // namespace dpl
