// SPDX-License-Identifier: Apache-2.0
// Saves what the user wishes: pictures and videos of the window, and files that the program `doppel` makes.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

class Exporter {
public:
    static constexpr double kStepS = 1.0 / 30;  // of a video
    static constexpr uint32_t kTurnFrames = 120;

    /** Begins, follows and ends what state.wantsExport, state.wantsDress and state.wantsExportEnd say, and tells state.exports of it. The
     * size is that of the window's pictures. Errors: a sentence for the user; the viewer goes on. Call once a frame, before the avatars are
     * posed. */
    Status fulfil(ViewerState& state, uint32_t widthPx, uint32_t heightPx);
    /** Begins a video of `frames` pictures. kind: Turntable or Clip. Without the program ffmpeg it is a folder of pictures, if `orFolder`.
     */
    Status beginVideo(ViewerState& state, ExportKind kind, std::filesystem::path file, uint32_t frames, uint32_t widthPx, uint32_t heightPx,
                      bool orFolder);

    /** A video is being made: time and camera are its own. */
    bool records() const { return recording_.has_value(); }
    /** Sets the clock for its next picture: a clip from its begin; once around from where the clock was, if it plays. */
    void advance(ViewerState& state) const;
    /** The picture of this frame is wanted, without panels. */
    bool wantsPicture() const { return records() || !picture_.empty(); }
    /** Takes that picture. Call in each frame that was shown. True: this was the last of a video. */
    Result<bool> take(ViewerState& state, std::span<const uint8_t> rgb, uint32_t widthPx, uint32_t heightPx);

    /** The avatars alone are wanted, as `view` sees them. */
    bool wantsCutOut() const { return !cutOut_.empty(); }
    /** Draws and saves them; waits for it. The avatars have their poses. Device: the device is lost; they stay wanted. */
    Status drawCutOut(ViewerState& state, const DplCamera& view, DplContext context);

private:
    Status begin(ViewerState& state, ExportKind kind, uint32_t widthPx, uint32_t heightPx);
    Status beginDressing(ViewerState& state);
    Status follow(ViewerState& state);
    void end(ViewerState& state);
    static std::filesystem::path folder(const ViewerState& state);
    void saved(ViewerState& state, const std::filesystem::path& file);

    std::optional<Recording> recording_;
    ExportKind recorded_ = ExportKind::Turntable;
    double fromRad_ = 0, fromS_ = 0;  // where the camera and the clock were
    double beganS_ = 0;               // of state.nowS
    std::filesystem::path picture_, cutOut_;
    std::unique_ptr<FileExport> file_;
    bool opens_ = false;  // that file, once it is saved
};

}  // namespace dpl
