// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/exporter.h"

#include <algorithm>
#include <cmath>

#include "apps/shared/pictures.h"
#include "apps/viewer/sample.h"
#include "reconstruction/base/image_codec.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;

void Exporter::saved(ViewerState& state, const fs::path& file) {
    if (!state.exports.open) state.messages.info(formatText("Saved {}", file.string()), state.nowS);
    state.exports.told = formatText("Saved {}", file.string());
}

Status Exporter::fulfil(ViewerState& state, uint32_t widthPx, uint32_t heightPx) {
    ExportWindow& told = state.exports;
    const auto wish = std::exchange(state.wantsExport, std::nullopt);
    if (std::exchange(state.wantsExportEnd, false) && told.running) {
        if (file_) file_->cancel();
        if (recording_) {
            end(state);
            told.told = "Cancelled; nothing was saved.";
        }
    }
    Status result;
    if (wish && (!told.running || *wish < ExportKind::Turntable)) result = begin(state, *wish, widthPx, heightPx);
    if (file_) {
        told.running.emplace(ExportProgress{file_->file().filename().string() + ": beginning"});
        if (const auto progress = file_->job().progress())
            told.running = {formatText("{}: {}", file_->file().filename().string(),
                                       !progress->left.empty()     ? progress->left
                                       : !progress->detail.empty() ? progress->detail
                                                                   : progress->stage),
                            progress->share};
        if (const auto finished = file_->finished()) {
            told.told.clear();
            if (*finished)
                saved(state, file_->file());
            else if (file_->job().cancelled())
                told.told = "Cancelled; nothing was saved.";
            else
                result = fail(finished->error().code, "{}: not saved: {}", file_->file().filename().string(), finished->error().message);
            file_.reset();
            told.running.reset();
        }
    }
    if (recording_) {
        told.running = {
            formatText("{}: picture {} of {}", recording_->path().filename().string(), recording_->done(), recording_->frames()),
            double(recording_->done()) / recording_->frames()};
        if (recorded_ == ExportKind::Turntable) state.camera.setAzimuth(fromRad_ + recording_->turnRad());
    }
    if (!result) told.told = result.error().message;
    return result;
}

Status Exporter::begin(ViewerState& state, ExportKind kind, uint32_t widthPx, uint32_t heightPx) {
    const ViewedSubject* chosen = state.chosen();
    if (const std::string why = whyNotExport(kind, chosen); !why.empty()) return fail(Code::InvalidArgument, "{}", why);
    state.exports.told.clear();
    std::error_code error;
    const fs::path typed = state.settings.exports;
    const fs::path file = exportFile(kind, chosen, typed.empty() ? fs::current_path(error) : typed);
    if (kind == ExportKind::Picture) {
        picture_ = file;
    } else if (kind == ExportKind::CutOut) {
        cutOut_ = file;
    } else if (!isByProgram(kind)) {
        const uint32_t frames = kind == ExportKind::Turntable
                                    ? kTurnFrames
                                    : uint32_t(std::max(1L, std::lround(chosen->clips[*chosen->clip].durationS / kStepS)));
        return beginVideo(state, kind, file, frames, widthPx, heightPx, true);
    } else {
        DPL_TRY(const fs::path program, doppelProgram());
        const auto arguments = [&](const fs::path& out) { return exportArguments(program, kind, *chosen, state.playback, out); };
        DPL_TRY(file_, FileExport::begin(file, arguments));
    }
    return {};
}

Status Exporter::beginVideo(ViewerState& state, ExportKind kind, fs::path file, uint32_t frames, uint32_t widthPx, uint32_t heightPx,
                            bool orFolder) {
    auto begun = Recording::begin(file, frames, widthPx, heightPx, 1 / kStepS);
    if (!begun && begun.error().code == Code::NotFound && orFolder)  // no ffmpeg: pictures instead
        begun = Recording::begin(nextFreeName((file.parent_path() / file.stem()).string(), ""), frames, widthPx, heightPx, 1 / kStepS);
    if (!begun) return begun.error();
    recording_.emplace(std::move(*begun));
    recorded_ = kind;
    fromRad_ = state.camera.azimuthRad(), fromS_ = state.playback.timeS;
    state.exports.open = false;
    return {};
}

void Exporter::advance(ViewerState& state) const {
    Playback& clock = state.playback;
    const double passedS = kStepS * recording_->done();
    if (recorded_ == ExportKind::Clip)
        clock.timeS = passedS;
    else if (clock.playing)
        clock.timeS = fromS_ + clock.speed * passedS;
}

void Exporter::end(ViewerState& state) {
    recording_.reset();
    state.exports.running.reset();
    if (recorded_ == ExportKind::Turntable) state.camera.setAzimuth(fromRad_);
    if (recorded_ == ExportKind::Clip) state.playback.timeS = fromS_;
}

Result<bool> Exporter::take(ViewerState& state, std::span<const uint8_t> rgb, uint32_t widthPx, uint32_t heightPx) {
    if (rgb.empty()) return false;
    if (const fs::path file = std::exchange(picture_, {}); !file.empty()) {
        Status written = writeScreenshot(file, rgb, widthPx, heightPx);
        if (!written) {
            state.exports.told = written.error().message;
            return written.error();
        }
        saved(state, file);
    }
    if (!recording_) return false;
    const Status added = recording_->add(rgb, widthPx, heightPx);
    if (added && recording_->done() < recording_->frames()) return false;
    const fs::path file = recording_->path();
    end(state);
    if (added) {
        saved(state, file);
        return true;
    }
    state.exports.told = added.error().message;
    return added.error();
}

Status Exporter::drawCutOut(ViewerState& state, const DplCamera& view, DplContext context) {
    const fs::path file = std::exchange(cutOut_, {});
    std::vector<DplAvatar> avatars;
    for (const ViewedSubject& subject : state.subjects)
        if (subject.shown) avatars.push_back(subject.avatar.handle());
    const auto made = [&]() -> Status {
        if (avatars.empty() || !context) return fail(Code::InvalidArgument, "{}: not saved, because no avatar is shown", file.string());
        std::vector<uint8_t> rgba(size_t(view.widthPx) * view.heightPx * 4);
        DplImage image{};
        image.structSize = sizeof image;
        image.flags = DPL_IMAGE_STRAIGHT_ALPHA;
        image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
        if (const DplResult drawn = dplRenderTogether(context, avatars.data(), uint32_t(avatars.size()), &view, 1, &image); drawn != DPL_OK)
            return fromSdk(doppel::lastError(drawn));
        DPL_TRY(const auto png, encodePng(rgba, view.widthPx, view.heightPx, 4));
        return writeFileAtomically(file, png);
    }();
    if (made)
        saved(state, file);
    else
        state.exports.told = made.error().message;
    return made;
}

}  // namespace dpl
