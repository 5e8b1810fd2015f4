// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/page/shown_avatar.h"

#include <algorithm>

#include "sdk/format/avatar_file.h"

namespace dpl {

Result<std::vector<uint8_t>> shownAvatar(std::span<const uint8_t> bytes, const ShownAs& as) {
    DPL_TRY(AvatarData avatar, readAvatar(bytes));
    DPL_TRY(const AvatarInfo info, inspectAvatar(bytes));
    for (const ClipData& clip : as.moreClips)
        if (std::none_of(avatar.clips.begin(), avatar.clips.end(), [&](const ClipData& has) { return has.name == clip.name; }))
            avatar.clips.push_back(clip);
    if (as.nameInstead) avatar.name = *as.nameInstead;
    if (as.withoutEvidence) avatar.evidence.clear();
    return writeAvatar(avatar, {.shPalette = info.shPaletteSize > 0, .compact = info.splatEncoding == 3, .bits = info.bits});
}

}  // namespace dpl
