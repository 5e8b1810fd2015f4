// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/video_writer.h"

#include <unistd.h>

#include <utility>

#include "sdk/core/files.h"

namespace dpl {

Result<VideoWriter> VideoWriter::open(const std::filesystem::path& path, uint32_t widthPx, uint32_t heightPx, double framesPerSecond) {
    const std::filesystem::path target = endOfLinks(path);
    std::error_code error;
    const std::filesystem::file_status there = std::filesystem::status(target, error);
    if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
        return fail(Code::InvalidArgument, "{} is no place for a video: there is something that is not a file; choose another output",
                    target.string());
    const std::filesystem::path temporary =
        target.parent_path() / ("." + target.stem().string() + ".part" + std::to_string(::getpid()) + ".mp4");
    const std::string size = formatText("{}x{}", widthPx, heightPx);
    ProgramRun run;
    // "file:" because ffmpeg takes text before a colon for a protocol.
    run.arguments = {"ffmpeg",
                     "-loglevel",
                     "error",
                     "-y",
                     "-f",
                     "rawvideo",
                     "-pix_fmt",
                     "rgb24",
                     "-s",
                     size,
                     "-r",
                     formatText("{}", framesPerSecond),
                     "-i",
                     "pipe:0",
                     "-c:v",
                     "libx264",
                     "-pix_fmt",
                     "yuv420p",
                     "-crf",
                     "18",
                     "-movflags",
                     "+faststart",
                     "file:" + temporary.string()};
    auto ffmpeg = FedProgram::start(std::move(run));
    if (!ffmpeg && ffmpeg.error().code == Code::NotFound)
        return fail(Code::NotFound,
                    "{}: writing video needs the program ffmpeg; install it (apt-get install ffmpeg) or name a folder to get PNG frames",
                    path.string());
    if (!ffmpeg) return ffmpeg.error();
    return VideoWriter(std::move(*ffmpeg), target, temporary, size);
}

VideoWriter::~VideoWriter() {
    if (!ffmpeg_) return;
    ffmpeg_.reset();
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
}

Status VideoWriter::write(std::span<const uint8_t> rgb) {
    ++frames_;
    if (ffmpeg_->write(rgb)) return {};
    const Status end = finish();
    return end ? fail(Code::Io, "{}: ffmpeg stopped reading before the last frame", path_.string()) : end;
}

/** The muxer "framecrc" prints the size of the stream and a line a frame. */
Status VideoWriter::checkWritten() const {
    size_t frames = 0;
    std::string said;
    bool sized = false;
    const Status read = runProgram({.arguments = {"ffmpeg", "-nostdin", "-loglevel", "error", "-i", "file:" + temporary_.string(), "-map",
                                                  "0:v:0", "-c", "copy", "-f", "framecrc", "-"},
                                    .line = [&](std::string_view line) {
                                        sized |= line == "#dimensions 0: " + size_;
                                        if (line.starts_with("0,"))
                                            ++frames;
                                        else if (!line.starts_with("#"))
                                            said = line;
                                    }});
    if (read && sized && said.empty() && frames == frames_) return {};
    std::error_code ignored;
    const auto space = std::filesystem::space(temporary_.parent_path().empty() ? "." : temporary_.parent_path(), ignored);
    return fail(Code::Io, "{}: ffmpeg wrote {} of {} frames{}; free some disk space, or choose another output", path_.string(), frames,
                frames_,
                !ignored && space.available < (1 << 20) ? ", and the disk is full"
                : said.empty()                          ? ""
                                                        : " (" + said.substr(0, 200) + ")");
}

Status VideoWriter::finish() {
    Status end = std::exchange(ffmpeg_, nullptr)->finish();
    if (!end) end = fail(Code::Io, "{}: {}", path_.string(), end.error().message);
    if (end) end = checkWritten();
    std::error_code error;
    if (end) std::filesystem::rename(temporary_, path_, error);
    if (end && error) end = fail(Code::Io, "{}: {}; choose another output", path_.string(), error.message());
    std::error_code ignored;
    if (!end) std::filesystem::remove(temporary_, ignored);
    return end;
}

}  // namespace dpl
