// SPDX-License-Identifier: Apache-2.0
// Writes and reads the streams of a file: plain words (encodings 1 and 2), or compact ones (encoding 3, splat_compact.h).
#include <algorithm>
#include <cstring>

#include "sdk/format/plain_bytes.h"
#include "sdk/format/splat_chunks.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_compact.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

void appendVarint(std::vector<uint8_t>& out, uint32_t value) {
    for (; value >= 0x80; value >>= 7) out.push_back(uint8_t(value | 0x80));
    out.push_back(uint8_t(value));
}

Result<std::vector<uint32_t>> decodeTriangleCounts(std::span<const uint8_t> bytes, uint32_t triangleCount, uint32_t splatCount) {
    if (bytes.size() < triangleCount)
        return fail(Code::CorruptData, "{} bytes of splat counts for {} triangles", bytes.size(), triangleCount);
    std::vector<uint32_t> start(size_t(triangleCount) + 1, 0);
    size_t at = 0;
    uint64_t total = 0;
    for (uint32_t t = 0; t < triangleCount; ++t) {
        uint64_t value = 0;
        for (uint32_t shift = 0;; shift += 7) {
            if (at == bytes.size() || shift > 28) return fail(Code::CorruptData, "splat count of triangle {} is cut off or too long", t);
            const uint8_t byte = bytes[at++];
            value |= uint64_t(byte & 0x7f) << shift;
            if (byte & 0x80) continue;
            if (byte == 0 && shift > 0) return fail(Code::CorruptData, "splat count of triangle {} is not in shortest form", t);
            break;
        }
        total += value;
        if (total > splatCount) return fail(Code::CorruptData, "triangles up to {} hold {} splats, the file has {}", t, total, splatCount);
        start[t + 1] = uint32_t(total);
    }
    if (total != splatCount) return fail(Code::CorruptData, "triangles hold {} splats, the file has {}", total, splatCount);
    if (at != bytes.size()) return fail(Code::CorruptData, "{} bytes after the last splat count", bytes.size() - at);
    return start;
}

Status checkChunk(const SplatChunk& c, size_t index, uint32_t first, uint32_t count, const std::vector<uint32_t>& start) {
    bool ok = c.firstSplat == first && c.splatCount == count && c.firstParent == 0;
    ok = ok && c.firstTriangle < c.endTriangle && c.endTriangle < start.size();
    ok = ok && start[c.firstTriangle] <= first && first < start[c.firstTriangle + 1];
    ok = ok && start[c.endTriangle - 1] < first + count && first + count <= start[c.endTriangle];
    if (!ok) return fail(Code::CorruptData, "chunk {} does not match the splat counts of its triangles", index);
    return checkRanges(c, index);
}

/** Copies rows of SH codes and refuses codes that no writer makes. */
Status readShRows(std::span<const uint8_t> bytes, size_t rows, CodedSplats& out) {
    const uint32_t inFile = (shCoefficientCount(out.shDegree) - 1) * 3, inMemory = shEntryBytes(out.shDegree);
    if (bytes.size() != rows * inFile) return fail(Code::CorruptData, "{} bytes do not hold {} rows of SH", bytes.size(), rows);
    out.sh.resize(inFile ? rows * inMemory : 0);
    for (size_t e = 0; inFile && e < rows; ++e) {
        std::memcpy(out.sh.data() + e * inMemory, bytes.data() + e * inFile, inFile);
        // Writers code −127 to 127; −128 would lie outside the range of its band.
        if (std::find(out.sh.begin() + ptrdiff_t(e * inMemory), out.sh.begin() + ptrdiff_t(e * inMemory + inFile), int8_t(-128)) !=
            out.sh.begin() + ptrdiff_t(e * inMemory + inFile))
            return fail(Code::CorruptData, "row {} of SH holds a code of -128", e);
    }
    return {};
}

/** Reads encodings 1 and 2: plain words. */
Result<std::vector<uint32_t>> readWords(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, const SplatHead& head,
                                        CodedSplats& out) {
    const uint32_t n = head.count;
    if (in.place.size() != size_t(n) * 4 || in.size.size() != size_t(n) * 4 || in.colour.size() != size_t(n) * 4 ||
        in.shIndex.size() != (head.paletteSize ? size_t(n) * 2 : 0) || !in.ranges.empty() || !in.coded.empty())
        return fail(Code::CorruptData, "splat streams of {}, {}, {} and {} bytes do not hold {} splats", in.place.size(), in.size.size(),
                    in.colour.size(), in.shIndex.size(), n);
    DPL_TRY(std::vector<uint32_t> start, decodeTriangleCounts(in.triangleCounts, uint32_t(mesh.triangles.size()), n));
    size_t chunkCount = 0;
    forChunks(mesh, start, [&](uint32_t, uint32_t) { ++chunkCount; });
    if (in.chunks.size() != chunkCount * sizeof(SplatChunk))
        return fail(Code::CorruptData, "{} bytes of chunk records, {} chunks expected", in.chunks.size(), chunkCount);
    fill(out.chunks, in.chunks), fill(out.place, in.place), fill(out.size, in.size), fill(out.colour, in.colour),
        fill(out.shIndex, in.shIndex);
    Status chunksFit;
    size_t index = 0;
    forChunks(mesh, start, [&](uint32_t first, uint32_t count) {
        if (chunksFit) chunksFit = checkChunk(out.chunks[index], index, first, count, start);
        if (chunksFit && head.paletteSize && !std::equal(out.chunks[index].shRange, out.chunks[index].shRange + 3, out.chunks[0].shRange))
            chunksFit = fail(Code::CorruptData, "chunk {} has another range of SH than the palette", index);
        ++index;
    });
    DPL_RETURN_IF_ERROR(chunksFit);
    return start;
}

}  // namespace

SplatStreams<std::vector<uint8_t>> writeSplatStreams(const CodedSplats& coded, size_t triangleCount, bool compact) {
    SplatStreams<std::vector<uint8_t>> out;
    const std::vector<uint32_t> start = triangleStarts(coded, triangleCount);
    const uint32_t inMemory = shEntryBytes(coded.shDegree), inFile = (shCoefficientCount(coded.shDegree) - 1) * 3;
    for (size_t at = 0; at < coded.sh.size(); at += inMemory)
        out.sh.insert(out.sh.end(), coded.sh.begin() + ptrdiff_t(at), coded.sh.begin() + ptrdiff_t(at + inFile));
    if (compact && coded.count() > 0) {
        writeCompact(coded, start, out);
        const size_t words =
            coded.count() * size_t(coded.shIndex.empty() ? 12 : 14) + coded.chunks.size() * sizeof(SplatChunk) + triangleCount;
        if (out.coded.size() >= coded.count() * size_t(kMinCompactBytes) && out.coded.size() + out.ranges.size() < words) return out;
        out.ranges.clear(), out.coded.clear();
    }
    for (size_t t = 0; t < triangleCount; ++t) appendVarint(out.triangleCounts, start[t + 1] - start[t]);
    std::vector<SplatChunk> chunks = coded.chunks;
    for (SplatChunk& c : chunks) c.firstParent = 0;
    out.chunks = bytesOf(chunks), out.place = bytesOf(coded.place), out.size = bytesOf(coded.size), out.colour = bytesOf(coded.colour),
    out.shIndex = bytesOf(coded.shIndex);
    return out;
}

Result<CodedSplats> readSplatStreams(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, const SplatHead& head,
                                     const ReadLimits& limits) {
    const uint32_t n = head.count;
    if (n > limits.maxSplats) return fail(Code::CorruptData, "{} splats, the limit is {}", n, limits.maxSplats);
    if (head.shDegree > kMaxShDegree) return fail(Code::CorruptData, "SH degree {}, at most {} is possible", head.shDegree, kMaxShDegree);
    if (head.paletteSize > kMaxShPalette || (head.paletteSize && (n == 0 || head.shDegree == 0)))
        return fail(Code::CorruptData, "an SH palette of {} entries for {} splats of SH degree {}", head.paletteSize, n, head.shDegree);
    CodedSplats out;
    out.shDegree = head.shDegree;
    const uint32_t rows = head.paletteSize ? head.paletteSize : n;
    DPL_RETURN_IF_ERROR(readShRows(in.sh, rows, out));
    DPL_TRY(const std::vector<uint32_t> start, head.bits ? readCompact(in, mesh, head, out) : readWords(in, mesh, head, out));
    for (size_t i = 0; i < out.shIndex.size(); ++i)
        if (out.shIndex[i] >= rows) return fail(Code::CorruptData, "splat {} has SH entry {} of {}", i, out.shIndex[i], rows);
    setParents(out, start);
    return out;
}

}  // namespace dpl
