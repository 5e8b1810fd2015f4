// SPDX-License-Identifier: Apache-2.0
// MP4 by the ffmpeg program: frames go down a pipe, the finished file is renamed into place.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>

#include "sdk/core/result.h"

namespace dpl {

class VideoWriter {
public:
    /** NotFound with the remedy when ffmpeg is not installed. Sizes must be even (H.264 with 4:2:0). */
    static Result<VideoWriter> open(const std::filesystem::path& path, uint32_t widthPx, uint32_t heightPx, double framesPerSecond);
    VideoWriter(VideoWriter&& other) noexcept;
    VideoWriter& operator=(VideoWriter&&) = delete;
    /** Closing without finish() drops the unfinished file. */
    ~VideoWriter();

    /** rgb: 3 bytes a pixel, tight rows. */
    Status write(std::span<const uint8_t> rgb);
    Status finish();

private:
    VideoWriter(std::FILE* pipe, std::filesystem::path path, std::filesystem::path temporary)
        : pipe_(pipe), path_(std::move(path)), temporary_(std::move(temporary)) {}
    std::FILE* pipe_ = nullptr;
    std::filesystem::path path_, temporary_;
};

}  // namespace dpl
