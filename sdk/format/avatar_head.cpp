// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/avatar_head.h"

#include <cstring>
#include <string_view>

#include "sdk/format/plain_bytes.h"

namespace dpl {

Status checkAvatarHead(std::span<const uint8_t> head, uint64_t fileBytes) {
    constexpr std::string_view kGzip = "\x1f\x8b", kSpz = "NGSP", kPly = "ply", kGlb = "glTF";
    if (beginsWith(head, kGzip) || beginsWith(head, kSpz) || beginsWith(head, kPly)) return {};
    if (fileBytes == 0) return fail(Code::CorruptData, "the file is empty; copy it again");
    if (beginsWith(head, "{") || beginsWith(head, "\xef\xbb\xbf{"))
        return fail(
            Code::Unsupported,
            "the file is text that begins like a .gltf; only binary glTF is read: convert it to a .glb, with its .bin files beside it "
            "(in Blender: export as 'glTF Binary')");
    if (!beginsWith(head, kGlb))
        return fail(
            Code::Unsupported,
            "the file is neither an avatar (.glb) nor general splats (.ply, .spz, .glb with KHR_gaussian_splatting); a .splat, .ksplat "
            "or .sog: convert it to one of these first, for example by splat-transform");
    constexpr size_t kStatedBytesAt = 8;
    uint32_t statedBytes = 0;
    if (head.size() >= kStatedBytesAt + 4) std::memcpy(&statedBytes, head.data() + kStatedBytesAt, 4);
    if (statedBytes != fileBytes)
        return fail(Code::CorruptData, "its header states {} bytes, the file has {}; copy it again", statedBytes, fileBytes);
    return {};
}

}  // namespace dpl
