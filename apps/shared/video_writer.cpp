// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/video_writer.h"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <utility>

namespace dpl {
namespace {

/** Quotes any text for the shell. */
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

}  // namespace

Result<VideoWriter> VideoWriter::open(const std::filesystem::path& path, uint32_t widthPx, uint32_t heightPx, double framesPerSecond) {
    if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0)
        return fail(Code::NotFound,
                    "{}: writing video needs the program ffmpeg; install it (apt-get install ffmpeg) or name a folder to get PNG frames",
                    path.string());
    std::signal(SIGPIPE, SIG_IGN);  // if ffmpeg dies, write() returns an error instead of killing this process
    const std::filesystem::path temporary =
        path.parent_path() / ("." + path.stem().string() + ".part" + std::to_string(::getpid()) + ".mp4");
    const std::string command = formatText(
        "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s {}x{} -r {} -i - -c:v libx264 -pix_fmt yuv420p -crf 18 -movflags "
        "+faststart {}",
        widthPx, heightPx, framesPerSecond, quoted("./" + temporary.lexically_proximate(std::filesystem::current_path()).string()));
    std::FILE* pipe = ::popen(command.c_str(), "w");
    if (!pipe) return fail(Code::Io, "{}: cannot start ffmpeg", path.string());
    return VideoWriter(pipe, path, temporary);
}

VideoWriter::VideoWriter(VideoWriter&& other) noexcept
    : pipe_(std::exchange(other.pipe_, nullptr)), path_(std::move(other.path_)), temporary_(std::move(other.temporary_)) {}

VideoWriter::~VideoWriter() {
    if (!pipe_) return;
    ::pclose(pipe_);
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
}

Status VideoWriter::write(std::span<const uint8_t> rgb) {
    if (std::fwrite(rgb.data(), 1, rgb.size(), pipe_) != rgb.size())
        return fail(Code::Io, "{}: ffmpeg stopped reading (disk full?); its message is above", path_.string());
    return {};
}

Status VideoWriter::finish() {
    const int status = ::pclose(std::exchange(pipe_, nullptr));
    std::error_code error;
    if (status == 0) std::filesystem::rename(temporary_, path_, error);
    if (status == 0 && !error) return {};
    std::filesystem::remove(temporary_, error);
    return fail(Code::Io, "{}: ffmpeg could not write the video; its message is above", path_.string());
}

}  // namespace dpl
