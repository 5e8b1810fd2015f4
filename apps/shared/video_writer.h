// SPDX-License-Identifier: Apache-2.0
// Writes MP4 with the ffmpeg program: frames go through a pipe into a temporary file, which finish() renames.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>

#include "sdk/core/result.h"

namespace dpl {

class VideoWriter {
public:
    /** Width and height must be even (H.264 with 4:2:0). Returns NotFound, with how to install it, when ffmpeg is missing. */
    static Result<VideoWriter> open(const std::filesystem::path& path, uint32_t widthPx, uint32_t heightPx, double framesPerSecond);
    VideoWriter(VideoWriter&& other) noexcept;
    VideoWriter& operator=(VideoWriter&&) = delete;
    /** Deletes the unfinished file if finish() was not called. */
    ~VideoWriter();

    /** rgb: one frame, 3 bytes per pixel, rows without padding. */
    Status write(std::span<const uint8_t> rgb);
    Status finish();

private:
    VideoWriter(std::FILE* pipe, std::filesystem::path path, std::filesystem::path temporary)
        : pipe_(pipe), path_(std::move(path)), temporary_(std::move(temporary)) {}
    std::FILE* pipe_ = nullptr;
    std::filesystem::path path_, temporary_;
};

}  // namespace dpl
