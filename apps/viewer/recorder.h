// SPDX-License-Identifier: Apache-2.0
// Writes pictures: screenshots, and turntables as an MP4 or a folder of PNGs. Files appear under their names only when they are complete.
#pragma once

#include <filesystem>
#include <memory>

#include "apps/shared/video_writer.h"

namespace dpl {

Status writeScreenshot(const std::filesystem::path& path, std::span<const uint8_t> rgb, uint32_t widthPx, uint32_t heightPx);

/** The first of PREFIX-1ENDING, PREFIX-2ENDING ... that does not exist in the current folder. */
std::filesystem::path nextFreeName(const std::string& prefix, const std::string& ending);

/** A new folder under a name of its own, which is removed again unless it was renamed. */
class RecordingFolder {
public:
    static Result<std::unique_ptr<RecordingFolder>> beside(const std::filesystem::path& target);
    ~RecordingFolder();
    RecordingFolder(const RecordingFolder&) = delete;
    RecordingFolder& operator=(const RecordingFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    Status rename(const std::filesystem::path& target);

private:
    explicit RecordingFolder(std::filesystem::path path) : path_(std::move(path)) {}
    std::filesystem::path path_;  // empty: renamed
};

class Recording {
public:
    /** path: a file that ends in .mp4, or a folder that does not exist yet. NotFound: a video needs the program ffmpeg. A video leaves out
     *  the last column or row of an odd picture. */
    static Result<Recording> begin(const std::filesystem::path& path, uint32_t frames, uint32_t widthPx, uint32_t heightPx,
                                   double framesPerSecond);
    // Destroying a turntable removes what is not finished.

    uint32_t frames() const { return frames_; }
    uint32_t done() const { return done_; }
    /** How far the camera has turned for the next picture, radians. */
    double turnRad() const;
    const std::filesystem::path& path() const { return path_; }

    /** The next picture, of the size given to begin; another one ends the turntable with an error. The last picture finishes the file. */
    Status add(std::span<const uint8_t> rgb, uint32_t widthPx, uint32_t heightPx);

private:
    Recording() = default;
    std::filesystem::path path_;
    std::unique_ptr<VideoWriter> video_;  // one of these two
    std::unique_ptr<RecordingFolder> pictures_;
    uint32_t frames_ = 0, done_ = 0, widthPx_ = 0, heightPx_ = 0;
};

}  // namespace dpl
