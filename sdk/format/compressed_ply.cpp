// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/compressed_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "sdk/core/task.h"
#include "sdk/format/ply_header.h"
#include "sdk/format/read_limits.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr size_t kChunkSplats = 256;
constexpr float kShReach = 4;  // bytes of element `sh` cover [−4, 4]

template <class T>
T load(const uint8_t* from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
}

/** Limits of a value within a chunk. */
struct Range {
    Vec3f low{0}, high{1};
    Vec3f at(const Vec3f& t) const { return low * (Vec3f(1) - t) + high * t; }
};

/** The `bits` bits from bit `shift` on, as a number in [0, 1]. */
float unorm(uint32_t word, uint32_t shift, uint32_t bits) {
    const uint32_t most = (1u << bits) - 1;
    return float(word >> shift & most) / float(most);
}
Vec3f unorm111011(uint32_t word) {
    return {unorm(word, 21, 11), unorm(word, 11, 10), unorm(word, 0, 11)};
}

/** The top two bits tell which of w, x, y, z is the largest; it is left out. The others follow in this order as q/√2 + ½, 10 bits each. */
Quatf unpackRotation(uint32_t word) {
    std::array<float, 4> q{};
    const uint32_t largest = word >> 30;
    float squares = 0;
    for (uint32_t k = 0, shift = 20; k < 4; ++k) {
        if (k == largest) continue;
        q[k] = (unorm(word, shift, 10) - 0.5f) * float(std::sqrt(2.0));
        squares += q[k] * q[k];
        shift -= 10;
    }
    q[largest] = std::sqrt(std::max(0.0f, 1 - squares));
    return glm::normalize(Quatf(q[0], q[1], q[2], q[3]));
}

/** The writer floors to 256 bins. The first and the last bin decode to the ends of the range, the others to their middles. */
float shOf(uint8_t code) {
    const float t = code == 0 ? 0.0f : code == 255 ? 1.0f : (float(code) + 0.5f) / 256;
    return (t - 0.5f) * 2 * kShReach;
}

/** Ranges of every chunk: columns min_<name> and max_<name>. */
Result<std::vector<Range>> readRanges(const PlyRows& chunks, std::array<const char*, 6> names) {
    DPL_TRY(const auto at, plyColumns(chunks, PlyType::F32, {names[0], names[1], names[2], names[3], names[4], names[5]}));
    std::vector<Range> out(chunks.count);
    for (size_t c = 0; c < chunks.count; ++c)
        for (int k = 0; k < 3; ++k)
            out[c].low[k] = load<float>(chunks.row(c) + at[size_t(k)]), out[c].high[k] = load<float>(chunks.row(c) + at[size_t(k) + 3]);
    return out;
}

}  // namespace

Result<StaticSplatData> readCompressedPly(std::span<const uint8_t> bytes, SplatRemarks* wanted) try {
    SplatRemarks unwanted;
    SplatRemarks& remarks = wanted ? *wanted : unwanted;
    DPL_TRY(const PlyHeader header, readPlyHeader(bytes));
    const uint64_t maxSplats = ReadLimits().maxSplats;
    DPL_TRY(const PlyRows chunks, plyRows(header, bytes, "chunk", maxSplats / kChunkSplats + 1));
    DPL_TRY(const PlyRows vertices, plyRows(header, bytes, "vertex", maxSplats));
    const size_t n = vertices.count;
    if (chunks.count != (n + kChunkSplats - 1) / kChunkSplats)
        return fail(Code::CorruptData, "PLY: {} chunks for {} splats, {} a chunk", chunks.count, n, kChunkSplats);
    DPL_TRY(const auto places, readRanges(chunks, {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z"}));
    DPL_TRY(const auto logScales,
            readRanges(chunks, {"min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"}));
    std::vector<Range> colours(chunks.count);  // older files have no ranges of colour: [0, 1]
    if (chunks.element->columns.contains("min_r")) {
        DPL_TRY(colours, readRanges(chunks, {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"}));
    }
    DPL_TRY(const auto packed, plyColumns(vertices, PlyType::U32, {"packed_position", "packed_rotation", "packed_scale", "packed_color"}));
    StaticSplatData s;
    PlyRows sh;
    std::vector<size_t> rest;
    if (header.find("sh")) {
        DPL_TRY(sh, plyRows(header, bytes, "sh", maxSplats));
        if (sh.count != n) return fail(Code::CorruptData, "PLY: {} rows of SH for {} splats", sh.count, n);
        DPL_TRY(rest, plyRestColumns(sh, PlyType::U8, remarks.shDegree));
    }
    noteShDegree(remarks);
    remarks.axes = axesOfComments(header.comments, remarks.notes);
    s.compensated = antialiasedByComments(header.comments);
    s.shDegree = std::min(remarks.shDegree, kMaxShDegree);
    const size_t perChannel = rest.size() / 3;
    std::vector<uint32_t> broken;
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    s.position.resize(n), s.rotation.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.sh.resize(n * coefficients * 3);
    for (size_t i = 0; i < n; ++i) {
        if (i % kLook == 0) {
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(n)));
        }
        const size_t chunk = i / kChunkSplats;
        const uint8_t* row = vertices.row(i);
        const uint32_t place = load<uint32_t>(row + packed[0]), rotation = load<uint32_t>(row + packed[1]),
                       scale = load<uint32_t>(row + packed[2]), colour = load<uint32_t>(row + packed[3]);
        s.position[i] = places[chunk].at(unorm111011(place));
        s.rotation[i] = unpackRotation(rotation);
        s.scaleM[i] = glm::exp(logScales[chunk].at(unorm111011(scale)));
        const Vec3f rgb = colours[chunk].at({unorm(colour, 24, 8), unorm(colour, 16, 8), unorm(colour, 8, 8)});
        s.opacity[i] = unorm(colour, 0, 8);
        float* out = s.sh.data() + i * coefficients * 3;
        for (int c = 0; c < 3; ++c) out[c] = (rgb[c] - 0.5f) / float(kShC0);
        for (uint32_t k = 1; k < coefficients; ++k)
            for (uint32_t c = 0; c < 3; ++c) out[k * 3 + c] = shOf(sh.row(i)[rest[c * perChannel + k - 1]]);
        const Vec3f all = s.position[i] + s.scaleM[i] + Vec3f(out[0], out[1], out[2]);
        if (!std::isfinite(all.x + all.y + all.z)) broken.push_back(uint32_t(i));
    }
    DPL_RETURN_IF_ERROR(dropBroken(s, broken, remarks));
    return s;
} catch (const std::bad_alloc&) {
    return outOfMemory("read a compressed PLY");
}

}  // namespace dpl
