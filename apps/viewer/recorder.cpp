// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/recorder.h"

#include <unistd.h>

#include <cstdio>
#include <numbers>

#include "reconstruction/base/image_codec.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;

Status writeScreenshot(const fs::path& path, std::span<const uint8_t> rgb, uint32_t widthPx, uint32_t heightPx) {
    DPL_TRY(const auto png, encodePng(rgb, widthPx, heightPx, 3));
    return writeFileAtomically(path, png);
}

fs::path nextFreeName(const std::string& prefix, const std::string& ending) {
    std::error_code ignored;
    for (int i = 1;; ++i)
        if (fs::path path = prefix + "-" + std::to_string(i) + ending; !fs::exists(path, ignored)) return path;
}

Result<std::unique_ptr<RecordingFolder>> RecordingFolder::beside(const fs::path& target) {
    const fs::path path = target.parent_path() / ("." + target.filename().string() + ".part" + std::to_string(::getpid()));
    std::error_code error;
    fs::create_directories(path, error);
    if (error) return fail(Code::Io, "cannot create {}: {}", path.string(), error.message());
    return std::unique_ptr<RecordingFolder>(new RecordingFolder(path));
}

RecordingFolder::~RecordingFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
}

Status RecordingFolder::rename(const fs::path& target) {
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) return fail(Code::Io, "{} cannot be created: {}", target.string(), error.message());
    path_.clear();
    return {};
}

Result<Recording> Recording::begin(const fs::path& path, uint32_t frames, uint32_t widthPx, uint32_t heightPx, double framesPerSecond) {
    Recording made;
    made.path_ = path;
    made.frames_ = frames, made.widthPx_ = widthPx, made.heightPx_ = heightPx;
    if (path.extension() == ".mp4") {
        DPL_TRY(auto video, VideoWriter::open(path, widthPx & ~1u, heightPx & ~1u, framesPerSecond));
        made.video_ = std::make_unique<VideoWriter>(std::move(video));
        return made;
    }
    std::error_code error;
    if (fs::exists(path, error)) return fail(Code::InvalidArgument, "{} exists already; name a new folder", path.string());
    DPL_TRY(made.pictures_, RecordingFolder::beside(path));
    return made;
}

double Recording::turnRad() const {
    return 2 * std::numbers::pi * double(done_) / double(frames_);
}

Status Recording::add(std::span<const uint8_t> rgb, uint32_t widthPx, uint32_t heightPx) {
    if (widthPx != widthPx_ || heightPx != heightPx_)
        return fail(Code::InvalidArgument, "{}: not written, because the window got another size meanwhile", path_.string());
    const bool last = done_ + 1 == frames_;
    if (video_) {
        const size_t row = size_t(widthPx & ~1u) * 3;
        std::vector<uint8_t> even;
        for (uint32_t y = 0; y < (heightPx & ~1u); ++y) {
            const auto from = rgb.begin() + ptrdiff_t(size_t(y) * widthPx * 3);
            even.insert(even.end(), from, from + ptrdiff_t(row));
        }
        DPL_RETURN_IF_ERROR(video_->write(even));
        if (last) DPL_RETURN_IF_ERROR(video_->finish());
    } else {
        char name[16];
        std::snprintf(name, sizeof name, "%05u.png", done_);
        DPL_RETURN_IF_ERROR(writeScreenshot(pictures_->path() / name, rgb, widthPx, heightPx));
        if (last) DPL_RETURN_IF_ERROR(pictures_->rename(path_));
    }
    ++done_;
    return {};
}

}  // namespace dpl
