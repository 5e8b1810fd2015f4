// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/live_person.h"

#include "reconstruction/judging/coach/move_poses.h"
#include "reconstruction/output/page/shown_avatar.h"
#include "reconstruction/run/stage.h"

namespace dpl {

std::string livePageKey(const std::filesystem::path& web) {
    if (web.empty()) return {};
    const auto module = readWebModule(web);
    if (!module) return "none";
    const std::string text = module->script + module->style;
    return hashBytes(module->packed) + hashBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Status bringToLife(const std::filesystem::path& web, std::span<const uint8_t> bytes, const AvatarData& avatar, ReportData& data) {
    if (web.empty()) return {};
    auto module = readWebModule(web);
    if (!module) {
        data.whyStill =
            formatText("The person can move on this page, but doppel found no web module. To get it, {}. Then run the same command again.",
                       kHowToGetModule);
        return {};
    }
    DPL_TRY(auto shown, shownAvatar(bytes, {.moreClips = walkClips(avatar.joints), .nameInstead = {}}));
    data.live = LivePerson{std::move(*module), std::move(shown)};
    return {};
}

}  // namespace dpl
