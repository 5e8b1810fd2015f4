// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/avatar_bytes.h"

#include "sdk/avatar/cloth_bounds.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/avatar_head.h"
#include "sdk/format/splat_file.h"

namespace dpl {

Result<std::vector<uint8_t>> readAvatarBytes(const std::filesystem::path& path) {
    return readFile(path, kMaxFileBytes, checkAvatarHead);
}

Result<AvatarData> avatarOf(const std::filesystem::path& path, std::span<const uint8_t> bytes, std::string_view what) {
    if (splatFormatOf(bytes) != SplatFormat::None)
        return fail(Code::Unsupported, "{} holds general splats, which have no {}; give an avatar", path.string(), what);
    auto avatar = readAvatar(bytes);
    if (!avatar) return fail(avatar.error().code, "{}: {}", path.string(), avatar.error().message);
    boundGarments(avatar->joints, avatar->mesh);
    return avatar;
}

}  // namespace dpl
