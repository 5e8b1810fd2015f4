// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/avatar_bytes.h"

#include <cstring>
#include <string_view>

#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_file.h"

namespace dpl {
namespace {

bool beginsWith(std::span<const uint8_t> bytes, std::string_view magic) {
    return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

Status checkHead(std::span<const uint8_t> head, uint64_t fileBytes) {
    constexpr std::string_view kGzip = "\x1f\x8b", kSpz = "NGSP", kPly = "ply", kGlb = "glTF";
    if (beginsWith(head, kGzip) || beginsWith(head, kSpz) || beginsWith(head, kPly)) return {};
    if (fileBytes == 0) return fail(Code::CorruptData, "the file is empty; copy it again");
    if (!beginsWith(head, kGlb))
        return fail(Code::Unsupported,
                    "the file is neither an avatar (.glb) nor general splats (.ply, .spz, .glb with KHR_gaussian_splatting)");
    constexpr size_t kStatedBytesAt = 8;
    uint32_t statedBytes = 0;
    if (head.size() >= kStatedBytesAt + 4) std::memcpy(&statedBytes, head.data() + kStatedBytesAt, 4);
    if (statedBytes != fileBytes)
        return fail(Code::CorruptData, "its header states {} bytes, the file has {}; copy it again", statedBytes, fileBytes);
    return {};
}

}  // namespace

Result<std::vector<uint8_t>> readAvatarBytes(const std::filesystem::path& path) {
    return readFile(path, kMaxFileBytes, checkHead);
}

Result<AvatarData> avatarOf(const std::filesystem::path& path, std::span<const uint8_t> bytes, std::string_view what) {
    if (splatFormatOf(bytes) != SplatFormat::None)
        return fail(Code::Unsupported, "{} holds general splats, which have no {}; give an avatar", path.string(), what);
    auto avatar = readAvatar(bytes);
    if (!avatar) return fail(avatar.error().code, "{}: {}", path.string(), avatar.error().message);
    return avatar;
}

}  // namespace dpl
