// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_file.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include "sdk/format/compressed_ply.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/plain_bytes.h"
#include "sdk/format/ply.h"
#include "sdk/format/ply_header.h"
#include "sdk/format/spz.h"

namespace dpl {
namespace {

constexpr double kStrayShare = 0.01;  // of the centres, left out at each end of an axis

/** The JSON chunk of a .glb; empty if there is none. */
std::string_view jsonOf(std::span<const uint8_t> bytes) {
    constexpr size_t kChunkAt = 12, kJsonAt = 20;
    if (bytes.size() < kJsonAt) return {};
    uint32_t length;
    std::memcpy(&length, bytes.data() + kChunkAt, 4);
    return {reinterpret_cast<const char*>(bytes.data()) + kJsonAt, std::min<size_t>(length, bytes.size() - kJsonAt)};
}

}  // namespace

const char* nameOf(SplatFormat format) {
    switch (format) {
        case SplatFormat::InriaPly:
            return "PLY";
        case SplatFormat::CompressedPly:
            return "compressed PLY";
        case SplatFormat::Spz:
            return "SPZ";
        case SplatFormat::Gltf:
            return "glTF KHR_gaussian_splatting";
        case SplatFormat::None:
            break;
    }
    return "no splat file";
}

SplatFormat splatFormatOf(std::span<const uint8_t> bytes) {
    if (beginsWith(bytes, "\x1f\x8b") || beginsWith(bytes, "NGSP")) return SplatFormat::Spz;
    if (beginsWith(bytes, "ply")) {
        const auto header = readPlyHeader(bytes);
        return header && header->find("chunk") ? SplatFormat::CompressedPly : SplatFormat::InriaPly;
    }
    if (beginsWith(bytes, "glTF")) {
        const std::string_view json = jsonOf(bytes);
        if (json.find("\"DPL_gaussian_avatar\"") == json.npos && json.find("\"KHR_gaussian_splatting\"") != json.npos)
            return SplatFormat::Gltf;
    }
    return SplatFormat::None;
}

Result<SplatFile> readSplats(std::span<const uint8_t> bytes, const ReadLimits& limits) {
    if (bytes.size() > limits.maxFileBytes)
        return fail(Code::CorruptData, "a file of {} bytes, the limit is {}", bytes.size(), limits.maxFileBytes);
    SplatFile file;
    file.format = splatFormatOf(bytes);
    SpzInfo spz;
    Result<StaticSplatData> splats =
        fail(Code::Unsupported, "not a splat file: PLY, compressed PLY, SPZ and .glb with KHR_gaussian_splatting are read");
    if (file.format == SplatFormat::InriaPly) splats = readPly(bytes);
    if (file.format == SplatFormat::CompressedPly) splats = readCompressedPly(bytes);
    if (file.format == SplatFormat::Spz) splats = readSpz(bytes, &spz);
    if (file.format == SplatFormat::Gltf) splats = readGltfSplats(bytes, limits);
    if (!splats) return splats.error();
    file.splats = std::move(*splats);
    file.version = spz.version;
    file.shDegree = file.format == SplatFormat::Spz ? spz.shDegree : file.splats.shDegree;
    return file;
}

SplatBox boxOf(const StaticSplatData& splats) {
    SplatBox box;
    std::vector<float> along(splats.count());
    if (along.empty()) return box;
    const size_t strays = size_t(kStrayShare * double(along.size()));
    for (int axis = 0; axis < 3; ++axis) {
        for (size_t i = 0; i < along.size(); ++i) along[i] = splats.position[i][axis];
        std::nth_element(along.begin(), along.begin() + ptrdiff_t(strays), along.end());
        box.low[axis] = along[strays];
        std::nth_element(along.begin(), along.end() - 1 - ptrdiff_t(strays), along.end());
        box.high[axis] = along[along.size() - 1 - strays];
    }
    return box;
}

}  // namespace dpl
