// SPDX-License-Identifier: Apache-2.0
// Writes MP4 with the ffmpeg program: frames go through its standard input into a temporary file, which finish() renames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "reconstruction/base/program.h"
#include "sdk/core/result.h"

namespace dpl {

class VideoWriter {
public:
    /** Width and height must be even (H.264 with 4:2:0). Returns NotFound, with how to install it, when ffmpeg is missing. */
    static Result<VideoWriter> open(const std::filesystem::path& path, uint32_t widthPx, uint32_t heightPx, double framesPerSecond);
    VideoWriter(VideoWriter&& other) noexcept = default;
    VideoWriter& operator=(VideoWriter&&) = delete;
    /** Deletes the unfinished file if finish() was not called. */
    ~VideoWriter();

    /** rgb: one frame, 3 bytes per pixel, rows without padding. After an error only the destructor may be called. */
    Status write(std::span<const uint8_t> rgb);
    /** Call once. Reads the frames back before the file gets its name, because ffmpeg ends well on a full disk. Errors carry ffmpeg's last
     *  line. */
    Status finish();

private:
    VideoWriter(std::unique_ptr<FedProgram> ffmpeg, std::filesystem::path path, std::filesystem::path temporary, std::string size)
        : ffmpeg_(std::move(ffmpeg)), path_(std::move(path)), temporary_(std::move(temporary)), size_(std::move(size)) {}
    Status checkWritten() const;

    std::unique_ptr<FedProgram> ffmpeg_;  // null once it has ended
    std::filesystem::path path_, temporary_;
    std::string size_;  // "640x480"
    size_t frames_ = 0;
};

}  // namespace dpl
