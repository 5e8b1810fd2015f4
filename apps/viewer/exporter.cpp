// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/exporter.h"

#include <algorithm>
#include <cmath>

#include "apps/shared/pictures.h"
#include "apps/viewer/sample.h"
#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/time_words.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;

constexpr uint32_t kTimedFrames = 3;  // of a video, before it says how long the rest takes

void Exporter::saved(ViewerState& state, const fs::path& file) {
    if (!state.exports.open) state.messages.info(formatText("Saved {}", file.string()), state.nowS);
    state.exports.told = formatText("Saved {}", file.string());
}

Status Exporter::fulfil(ViewerState& state, uint32_t widthPx, uint32_t heightPx) {
    ExportWindow& told = state.exports;
    const auto wish = std::exchange(state.wantsExport, std::nullopt);
    const bool dress = std::exchange(state.wantsDress, false);
    if (std::exchange(state.wantsExportEnd, false) && told.running) {
        if (file_) file_->cancel();
        if (recording_) {
            end(state);
            told.told = "Cancelled; nothing was saved.";
        }
    }
    Status result;
    if (wish && (!told.running || *wish < ExportKind::Turntable)) result = begin(state, *wish, widthPx, heightPx);
    if (dress && !told.running) result = beginDressing(state);
    if (Status followed = follow(state); !followed) result = std::move(followed);
    if (recording_) {
        const uint32_t done = recording_->done(), frames = recording_->frames();
        const double leftS = done >= kTimedFrames ? (state.nowS - beganS_) / done * (frames - done) : 0;
        told.running = {formatText("{}: picture {} of {}{}", recording_->path().filename().string(), done, frames,
                                   done >= kTimedFrames ? ", " + wordsOfTimeLeft(leftS) : ""),
                        double(done) / frames};
        if (recorded_ == ExportKind::Turntable) state.camera.setAzimuth(fromRad_ + recording_->turnRad());
    }
    if (!result) told.told = result.error().message;
    return result;
}

/** The program that writes a file. */
Status Exporter::follow(ViewerState& state) {
    if (!file_) return {};
    ExportWindow& told = state.exports;
    const std::string name = file_->file().filename().string();
    told.running.emplace(ExportProgress{name + ": beginning"});
    if (const auto progress = file_->job().progress()) {
        const std::string& doing = !progress->left.empty()     ? progress->left
                                   : !progress->detail.empty() ? progress->detail
                                                               : progress->stage;
        told.running = {formatText("{}: {}", name, doing), progress->share};
    }
    const auto finished = file_->finished();
    if (!finished) return {};
    Status result;
    told.told.clear();
    told.running.reset();
    const bool opens = std::exchange(opens_, false);
    if (*finished) {
        saved(state, file_->file());
        if (opens) state.wantsOpen = file_->file().string();
    } else if (file_->job().cancelled()) {
        told.told = "Cancelled; nothing was saved.";
    } else {
        result = fail(finished->error().code, "{}: not saved: {}", name, finished->error().message);
    }
    file_.reset();
    return result;
}

/** Where exports go. */
fs::path Exporter::folder(const ViewerState& state) {
    std::error_code error;
    return state.settings.exports.empty() ? fs::current_path(error) : fs::path(state.settings.exports);
}

Status Exporter::beginDressing(ViewerState& state) {
    const ViewedSubject* wearer = state.chosen();
    if (!wearer || !canDress(*wearer)) return fail(Code::InvalidArgument, "Select an avatar that has a file of its own.");
    state.exports.told.clear();
    DPL_TRY(const fs::path program, doppelProgram());
    const fs::path file = nextFreeName((folder(state) / (fs::path(wearer->file).stem().string() + "-dressed")).string(), ".glb");
    const auto arguments = [&](const fs::path& out) { return dressArguments(program, *wearer, state.outfit, state.subjects, out); };
    if (arguments(file).empty()) return fail(Code::InvalidArgument, "Choose whose garment {} puts on.", wearer->file);
    DPL_TRY(file_, FileExport::begin(file, arguments));
    opens_ = true;
    return {};
}

Status Exporter::begin(ViewerState& state, ExportKind kind, uint32_t widthPx, uint32_t heightPx) {
    const ViewedSubject* chosen = state.chosen();
    const ViewedSubject* player = state.player();
    if (const std::string why = whyNotExport(kind, chosen, player); !why.empty()) return fail(Code::InvalidArgument, "{}", why);
    state.exports.told.clear();
    const fs::path file = exportFile(kind, chosen, folder(state));
    if (kind == ExportKind::Picture) {
        picture_ = file;
    } else if (kind == ExportKind::CutOut) {
        cutOut_ = file;
    } else if (!isByProgram(kind)) {
        const uint32_t frames = kind == ExportKind::Turntable
                                    ? kTurnFrames
                                    : uint32_t(std::max(1L, std::lround(player->clips[*player->clip].durationS / kStepS)));
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
    fromRad_ = state.camera.azimuthRad(), fromS_ = state.playback.timeS, beganS_ = state.nowS;
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
    else if (made.error().code == Code::Device)
        cutOut_ = file;  // once the device is opened again
    else
        state.exports.told = made.error().message;
    return made;
}

}  // namespace dpl
