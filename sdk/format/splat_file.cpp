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

constexpr float kReach = 3;           // standard deviations that show of a splat
constexpr double kStrayShare = 0.01;  // of the centres, left out at each end of an axis

/** The JSON chunk of a .glb; empty if there is none. */
std::string_view jsonOf(std::span<const uint8_t> bytes) {
    constexpr size_t kChunkAt = 12, kJsonAt = 20;
    if (bytes.size() < kJsonAt) return {};
    uint32_t length;
    std::memcpy(&length, bytes.data() + kChunkAt, 4);
    return {reinterpret_cast<const char*>(bytes.data()) + kJsonAt, std::min<size_t>(length, bytes.size() - kJsonAt)};
}

bool isSpz(std::span<const uint8_t> bytes) {
    return beginsWith(bytes, "\x1f\x8b") || beginsWith(bytes, "NGSP");
}

bool isSplatGltf(std::span<const uint8_t> bytes) {
    if (!beginsWith(bytes, "glTF")) return false;
    const std::string_view json = jsonOf(bytes);
    return json.find("\"DPL_gaussian_avatar\"") == json.npos && json.find("\"KHR_gaussian_splatting\"") != json.npos;
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
    if (isSpz(bytes)) return SplatFormat::Spz;
    if (beginsWith(bytes, "ply")) {
        const auto header = readPlyHeader(bytes);
        return header && header->find("chunk") ? SplatFormat::CompressedPly : SplatFormat::InriaPly;
    }
    return isSplatGltf(bytes) ? SplatFormat::Gltf : SplatFormat::None;
}

bool isSplatFile(std::span<const uint8_t> bytes) {
    return isSpz(bytes) || beginsWith(bytes, "ply") || isSplatGltf(bytes);
}

Result<SplatFile> readSplats(std::span<const uint8_t> bytes, const ReadLimits& limits) try {
    if (bytes.size() > limits.maxFileBytes)
        return fail(Code::CorruptData, "a file of {} bytes, the limit is {}", bytes.size(), limits.maxFileBytes);
    SplatFile file;
    file.format = splatFormatOf(bytes);
    SplatRemarks& remarks = file.remarks;
    SpzInfo spz;
    Result<StaticSplatData> splats =
        fail(Code::Unsupported, "not a splat file: PLY, compressed PLY, SPZ and .glb with KHR_gaussian_splatting are read");
    if (file.format == SplatFormat::InriaPly) splats = readPly(bytes, &remarks);
    if (file.format == SplatFormat::CompressedPly) splats = readCompressedPly(bytes, &remarks);
    if (file.format == SplatFormat::Spz) splats = readSpz(bytes, &spz);
    if (file.format == SplatFormat::Gltf) splats = readGltfSplats(bytes, limits, &remarks);
    if (!splats) return splats.error();
    file.splats = std::move(*splats);
    if (file.format == SplatFormat::Spz) remarks = std::move(spz.remarks), file.version = spz.version;
    DPL_RETURN_IF_ERROR(checkPrecision(file.splats, remarks));
    turnSplats(file.splats, remarks.axes.uprightFromFile);
    return file;
} catch (const std::bad_alloc&) {
    return outOfMemory("read splats");
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
    std::vector<float>& sizes = along;
    for (size_t i = 0; i < sizes.size() && i < splats.scaleM.size(); ++i) {
        const Vec3f& s = splats.scaleM[i];
        sizes[i] = std::max({s.x, s.y, s.z});
    }
    std::nth_element(sizes.begin(), sizes.begin() + ptrdiff_t(sizes.size() / 2), sizes.end());
    const float reach = splats.scaleM.empty() ? 0 : kReach * sizes[sizes.size() / 2];
    const Vec3f middle = 0.5f * (box.low + box.high), half = 0.5f * (box.high - box.low);
    if (std::max({half.x, half.y, half.z}) < reach) box = {middle - Vec3f(reach), middle + Vec3f(reach)};
    return box;
}

}  // namespace dpl
