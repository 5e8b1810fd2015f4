// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/compared_avatar.h"

#include <algorithm>

#include "apps/shared/pictures.h"

namespace dpl {
namespace {

constexpr float kMargin = 24;

void removePictures(ComparedAvatar& compared, platform::Shell& shell) {
    for (ShownPicture* picture : {&compared.photo, &compared.drawn, &compared.error}) {
        shell.removePicture(picture->id);
        *picture = {};
    }
}

Result<ShownPicture> shown(platform::Shell& shell, const Picture& picture) {
    const auto added = shell.addPicture(picture.pixels, picture.widthPx, picture.heightPx);
    if (!added) return fromSdk(added.error());
    return ShownPicture{*added, picture.widthPx, picture.heightPx};
}

}  // namespace

Status beginComparing(ViewerState& state, platform::Shell& shell, const std::filesystem::path& scan, const std::string& frame) {
    const ViewedSubject* chosen = state.chosen();
    if (!chosen) return fail(Code::InvalidArgument, "a scan is compared with an avatar; load the avatar of its run first");
    if (!chosen->comparable)
        return fail(
            Code::InvalidArgument,
            "{}: nobody knows from where its scan saw it; load avatar.glb from the folder of its run, with frames.json and poses.json",
            chosen->file);
    endComparing(state, shell);
    state.compared.emplace();
    ComparedAvatar& compared = *state.compared;
    compared.avatar = chosen->avatar.handle();
    compared.file = chosen->path, compared.scan = scan, compared.firstFrame = frame;
    return {};
}

void endComparing(ViewerState& state, platform::Shell& shell) {
    if (state.compared) removePictures(*state.compared, shell);
    state.compared.reset();
}

std::optional<CompareTask> comparisonToDraw(ViewerState& state) {
    if (!state.compared) return std::nullopt;
    ComparedAvatar& compared = *state.compared;
    const auto frame = compared.comparison.next();
    if (!frame) return std::nullopt;
    return CompareTask{compared.file, compared.scan, *frame, std::exchange(compared.firstFrame, {})};
}

Status takeCompared(ViewerState& state, platform::Shell& shell, LoadedFile news) {
    if (!state.compared || state.compared->file != news.compared->file) return {};  // ended meanwhile
    ComparedAvatar& compared = *state.compared;
    Comparison& comparison = compared.comparison;
    if (!news.compared->frames.empty()) comparison.setFrames(std::move(news.compared->frames));
    if (comparison.frames().empty()) {  // it cannot be compared at all
        endComparing(state, shell);
        return fail(Code::NotFound, "{}", news.error);
    }
    if (news.compared->named) comparison.choose(news.compared->frame);
    comparison.arrived(news.compared->frame);
    removePictures(compared, shell);
    compared.problem = news.error;
    if (!news.error.empty()) return {};
    const ComparedPictures& pictures = news.compared->pictures;
    compared.db = pictures.db, compared.masked = pictures.masked;
    DPL_TRY(compared.photo, shown(shell, pictures.photo));
    DPL_TRY(compared.drawn, shown(shell, pictures.avatar));
    DPL_TRY(compared.error, shown(shell, pictures.error));
    return {};
}

ComparedPlaces placesOfComparison(const ViewerState& state, float width, float height) {
    ComparedPlaces out;
    if (!state.compared || state.compared->photo.id == 0) return out;
    const ComparedAvatar& compared = *state.compared;
    const Comparison& comparison = compared.comparison;
    const FreeSpan free = freeSpan(state, width);
    const bool beside = comparison.way == Comparison::Way::Beside;
    const float roomX = (free.right - free.left - (beside ? 3 : 2) * kMargin) / (beside ? 2 : 1), roomY = height - 2 * kMargin;
    const auto columns = float(compared.photo.widthPx), rows = float(compared.photo.heightPx);
    const float fit = std::min(roomX / columns, roomY / rows), middle = 0.5f * (free.left + free.right);
    if (!(fit > 0)) return out;
    const float wide = fit * columns, top = 0.5f * (height - fit * rows), bottom = top + fit * rows;
    out.left = beside ? middle - wide - 0.5f * kMargin : middle - 0.5f * wide;
    out.right = out.left + wide;
    if (beside) {
        const float right = middle + 0.5f * kMargin;
        out.pictures = {{compared.photo.id, out.left, top, out.right, bottom}, {compared.drawn.id, right, top, right + wide, bottom}};
        return out;
    }
    const uint32_t other = comparison.way == Comparison::Way::Error ? compared.error.id : compared.drawn.id;
    const float at = out.left + comparison.wipe * wide;
    out.pictures = {{compared.photo.id, out.left, top, at, bottom, 0, 0, comparison.wipe, 1},
                    {other, at, top, out.right, bottom, comparison.wipe, 0, 1, 1}};
    return out;
}

}  // namespace dpl
