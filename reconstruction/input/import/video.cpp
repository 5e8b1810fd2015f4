// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/video.h"
#include "reconstruction/base/image_size.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "reconstruction/base/program.h"
#include "reconstruction/input/cameras/camera_check.h"
#include "reconstruction/input/import/folder_contents.h"
#include "sdk/core/numbers.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kFramesPerSecond = 12;
constexpr size_t kMaxAnalysed = 1500;
constexpr uint32_t kShortSidePx = 270;      // of analysed frames: motion blur of a few pixels of the video still shows
constexpr size_t kMaxProbeBytes = 1 << 20;  // of ffprobe's answer
constexpr double kProbeTimeoutS = 30;
constexpr double kDecodeTimeoutS = 1800;
constexpr double kCutToleranceS = 1.0;  // last frame against the stated duration: containers round, and audio may be longer

// Prints the time of each frame; the filter prints nothing for frames without metadata, so it adds some.
constexpr const char* kPrintTimes = "metadata=add:key=doppel:value=1,metadata=print:file=-";
constexpr size_t kMaxReasonBytes = 4096;

/** What ffmpeg said, as a sentence for people. */
std::string reasonOf(const std::string& message) {
    if (message.find("moov atom not found") != std::string::npos || message.find("End of file") != std::string::npos)
        return "it is cut off before its index; copy it again from the phone";
    if (message.find("Invalid data") != std::string::npos || message.find("EBML header parsing failed") != std::string::npos)
        return "it is damaged, or not a video; copy it again from the phone";
    if (message.find("Decoder") != std::string::npos || message.find("codec") != std::string::npos)
        return "this ffmpeg cannot decode it; convert it to H.264";
    if (message.find("not on whitelist") != std::string::npos) return "it is not a kind of video that is read; convert it to H.264 in .mp4";
    const size_t begin = message.find_first_not_of(" {}\n");
    return begin == std::string::npos ? "ffmpeg gives no reason; copy it again from the phone"
                                      : message.substr(begin, message.find('\n', begin) - begin);
}

/** Options that keep a hostile file from opening anything but itself: no network, no playlists. */
std::vector<std::string> inputOptions(const fs::path& path) {
    std::string formats;
    for (const VideoEnding& ending : kVideoEndings) formats += (formats.empty() ? "" : ",") + std::string(ending.format);
    return {"-protocol_whitelist", "file", "-format_whitelist", formats, "-i", "file:" + fs::absolute(path).string()};
}

/** Refuses files that show in their first bytes that they are no video: ffmpeg would call them cut off. */
Status checkStart(const fs::path& path) {
    char start[512];
    std::ifstream in(path, std::ios::binary);
    in.read(start, sizeof start);
    const std::string_view text(start, size_t(in.gcount()));
    if (text.empty()) return fail(Code::CorruptData, "{} is empty; copy it again from the phone", path.string());
    if (std::all_of(text.begin(), text.end(), [](unsigned char c) { return c >= 0x20 || std::isspace(c); }))
        return fail(Code::CorruptData, "{} is text, not a video; give the file that the phone recorded", path.string());
    return {};
}

Status runFfmpeg(std::vector<std::string> arguments, const fs::path& video, const VideoWork& work, double timeoutS,
                 const std::function<void(std::string_view)>& line) {
    ProgramRun run;
    run.arguments = std::move(arguments);
    run.log = work.folder / "ffmpeg.log";
    std::string said;
    run.line = [&](std::string_view text) {
        if (said.size() < kMaxReasonBytes && !text.starts_with("frame:")) said.append(text).push_back('\n');
        if (line) line(text);
    };
    run.cancel = work.cancel;
    run.timeoutS = timeoutS;
    const Status ended = runProgram(run);
    if (ended) return {};
    if (ended.error().code == Code::Cancelled) return fail(Code::Cancelled, "stopped while reading {}", video.string());
    if (ended.error().code == Code::NotFound) return ended;  // readers of captures have looked for ffmpeg before
    if (said.find("No space left on device") != std::string::npos)
        return fail(Code::Io, "cannot write frames of {} to {}: its disk is full; free some space, or choose another output with -o",
                    video.string(), work.folder.string());
    return fail(Code::CorruptData, "{} cannot be read: {}", video.string(), reasonOf(said));
}

std::string textOf(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) return {};
    return found->is_string() ? found->get<std::string>() : found->is_number() ? found->dump() : std::string();
}
double numberOf(const json& object, const char* key) {
    double value = 0;
    return readNumber(textOf(object, key), value) ? value : 0;
}

/** Degrees of the display matrix, or of the older tag. */
double rotationOf(const json& stream) {
    if (const auto list = stream.find("side_data_list"); list != stream.end() && list->is_array())
        for (const json& entry : *list)
            if (entry.is_object() && entry.contains("rotation")) return numberOf(entry, "rotation");
    if (const auto tags = stream.find("tags"); tags != stream.end() && tags->is_object()) return numberOf(*tags, "rotate");
    return 0;
}

/** Width over height of a stored pixel, "4:3"; 1 where it is not stated or square to half a percent, as from a rounded size. 0: damaged. */
double pixelAspectOf(const json& stream) {
    constexpr double kSquare = 0.005, kMost = 10;
    const std::string text = textOf(stream, "sample_aspect_ratio");
    const size_t colon = text.find(':');
    double width = 0, height = 0;
    if (colon == std::string::npos || !readNumber(std::string_view(text).substr(0, colon), width) ||
        !readNumber(std::string_view(text).substr(colon + 1), height) || width == 0 || height == 0)
        return 1;
    const double aspect = width / height;
    if (!(aspect >= 1 / kMost && aspect <= kMost)) return 0;
    return std::abs(aspect - 1) <= kSquare ? 1 : aspect;
}

/** Seconds of "00:01:42.500000000", as Matroska's tags state the length of a stream; 0 for everything else. */
double clockSeconds(std::string_view text) {
    const size_t first = text.find(':'), second = text.find(':', std::min(first, text.size() - 1) + 1);
    double hours = 0, minutes = 0, seconds = 0;
    if (first == std::string_view::npos || second == std::string_view::npos || !readNumber(text.substr(0, first), hours) ||
        !readNumber(text.substr(first + 1, second - first - 1), minutes) || !readNumber(text.substr(second + 1), seconds))
        return 0;
    return 3600 * hours + 60 * minutes + seconds;
}

/** How long a video lasts from its first frame on. Some containers state the time at which it ends, which is later if it starts late. */
double durationOf(const json& stream, const json& format) {
    if (const double own = numberOf(stream, "duration"); own > 0) return own;
    double end = 0;
    if (const auto tags = stream.find("tags"); tags != stream.end() && tags->is_object())
        for (const auto& [key, value] : tags->items())
            if (key.starts_with("DURATION") && value.is_string() && !value.get_ref<const std::string&>().empty())
                end = clockSeconds(value.get_ref<const std::string&>());
    if (end <= 0) end = numberOf(format, "duration");
    const double start = std::max(0.0, numberOf(format, "start_time"));
    return end > start ? end - start : end;
}

/** A frame's line of ffmpeg's metadata filter: "frame:12   pts:3072    pts_time:0.4". */
bool parseFrameLine(std::string_view line, VideoFrame& frame) {
    const auto after = [&](std::string_view key) -> std::string_view {
        const size_t at = line.find(key);
        if (at == std::string_view::npos) return {};
        const std::string_view rest = line.substr(at + key.size());
        return rest.substr(0, rest.find_first_of(" \t"));
    };
    return line.starts_with("frame:") && readNumber(after(" pts:"), frame.pts) && readNumber(after("pts_time:"), frame.timeS);
}

/** Even sides of the picture scaled so that `side(width, height)` becomes `target`, never larger than it is. */
std::pair<uint32_t, uint32_t> scaledSize(const VideoInfo& video, uint32_t side, uint32_t target) {
    const double factor = std::min(1.0, double(target) / double(side));
    const auto even = [&](uint32_t length) { return std::max(2u, uint32_t(std::lround(length * factor / 2)) * 2); };
    return {even(video.widthPx), even(video.heightPx)};
}

std::string toneMap() {
    // Linear light, BT.709 primaries, Hable's curve, then the usual 8-bit transfer. 100 cd/m² is the white of SDR.
    return "zscale=t=linear:npl=100,format=gbrpf32le,zscale=p=bt709,tonemap=hable:desat=0,zscale=t=bt709:m=bt709:r=tv,format=yuv420p,";
}

std::string jpegName(size_t number) {
    std::string digits = std::to_string(number);
    digits.insert(0, 6 - std::min<size_t>(6, digits.size()), '0');
    return digits + ".jpg";
}

Result<fs::path> emptyFolder(const fs::path& folder) {
    std::error_code error;
    fs::remove_all(folder, error);
    fs::create_directories(folder, error);
    if (error) return fail(Code::Io, "cannot create {}: {}", folder.string(), error.message());
    return folder;
}

/** Which frames of a video become files, and where. */
struct WrittenFrames {
    std::vector<std::string> inputOptions;  // before the input's own
    std::string select;                     // an expression of ffmpeg's filter
    size_t most = 0, first = 0;             // files, and the number of the first: jpegName()
    fs::path folder;
};

/** Writes upright 8-bit sRGB JPEG files. `written` hears of each. */
Status writeJpegs(const VideoInfo& video, const WrittenFrames& frames, uint32_t longSidePx, const VideoWork& work,
                  const std::function<void(const VideoFrame&)>& written) {
    const auto [width, height] = scaledSize(video, std::max(video.widthPx, video.heightPx), longSidePx);
    // JPEG decoders expect BT.601 in full range, whatever the video has.
    const std::string filter = formatText(
        "select='{}',{}scale={}:{}:flags=lanczos:in_color_matrix={}:out_color_matrix=smpte170m:out_range=full,format=yuvj420p,"
        "{}",
        frames.select, video.hdr ? toneMap() : "", width, height, video.hdr ? "bt709" : video.colourMatrix, kPrintTimes);
    std::string pattern;  // a percent sign of the folder is doubled for ffmpeg
    for (char c : (frames.folder / "").string()) pattern += c == '%' ? "%%" : std::string(1, c);
    pattern += "%06d.jpg";
    std::vector<std::string> arguments = {"ffmpeg", "-hide_banner", "-nostdin", "-loglevel", "error", "-y"};
    arguments.insert(arguments.end(), frames.inputOptions.begin(), frames.inputOptions.end());
    const auto input = inputOptions(video.path);
    arguments.insert(arguments.end(), input.begin(), input.end());
    for (const std::string& word :
         {std::string("-map"), std::string("0:V:0"), std::string("-vf"), filter, std::string("-fps_mode"), std::string("passthrough"),
          std::string("-frames:v"), std::to_string(frames.most), std::string("-c:v"), std::string("mjpeg"), std::string("-q:v"),
          std::string("2"), std::string("-start_number"), std::to_string(frames.first), std::string("-f"), std::string("image2"), pattern})
        arguments.push_back(word);
    return runFfmpeg(arguments, video.path, work, kDecodeTimeoutS, [&](std::string_view line) {
        if (VideoFrame frame; parseFrameLine(line, frame)) written(frame);
    });
}

}  // namespace

Result<VideoInfo> probeVideo(const fs::path& path, const VideoWork& work) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return fail(Code::NotFound, "{}: no such video", path.string());
    DPL_RETURN_IF_ERROR(checkStart(path));
    std::vector<std::string> arguments = {"ffprobe", "-v", "error", "-select_streams", "V", "-show_streams", "-show_format", "-of", "json"};
    const auto input = inputOptions(path);
    arguments.insert(arguments.end(), input.begin(), input.end());
    std::string answer;
    DPL_RETURN_IF_ERROR(runFfmpeg(arguments, path, work, kProbeTimeoutS, [&](std::string_view line) {
        if (answer.size() < kMaxProbeBytes) answer.append(line).push_back('\n');
    }));
    const size_t begin = answer.find('{');  // warnings may come first
    const json probe = json::parse(begin == std::string::npos ? "" : answer.substr(begin), nullptr, false);
    if (!probe.is_object() || !probe.contains("streams") || !probe["streams"].is_array() || probe["streams"].empty())
        return fail(Code::Unsupported, "{} holds no video stream; give the video that the phone recorded", path.string());
    const json& stream = probe["streams"][0];
    VideoInfo video;
    video.path = path;
    video.codec = textOf(stream, "codec_name");
    const double width = numberOf(stream, "width"), height = numberOf(stream, "height");
    if (!(width >= 16 && height >= 16))
        return fail(Code::Unsupported, "{}: ffmpeg does not know its codec ('{}'); convert it to H.264", path.string(), video.codec);
    DPL_RETURN_IF_ERROR(checkImageSize(uint64_t(width), uint64_t(height), path.string()));
    const double aspect = pixelAspectOf(stream);
    if (aspect == 0)
        return fail(Code::CorruptData,
                    "{} says that its pixels have the shape {}, which is damaged; convert it with ffmpeg -i IN -vf setsar=1 OUT",
                    path.string(), textOf(stream, "sample_aspect_ratio"));
    // The short side of a pixel is stretched, so that no detail is lost.
    video.storedWidthPx = uint32_t(width), video.storedHeightPx = uint32_t(height);
    video.widthPx = uint32_t(std::lround(width * std::max(1.0, aspect))),
    video.heightPx = uint32_t(std::lround(height / std::min(1.0, aspect)));
    DPL_RETURN_IF_ERROR(checkImageSize(video.widthPx, video.heightPx, path.string()));
    if (std::lround(std::abs(rotationOf(stream)) / 90) % 2 == 1)
        std::swap(video.widthPx, video.heightPx), std::swap(video.storedWidthPx, video.storedHeightPx);
    video.otherStreams = probe["streams"].size() - 1;
    const json format = probe.value("format", json::object());
    video.durationS = durationOf(stream, format);
    const std::string transfer = textOf(stream, "color_transfer");
    video.hdr = transfer == "arib-std-b67" || transfer == "smpte2084";
    const std::string matrix = textOf(stream, "color_space");
    video.colourMatrix = matrix == "bt709" || matrix == "smpte170m" || matrix == "bt470bg" || matrix == "bt2020nc" ? matrix
                         : std::min(width, height) >= 720                                                          ? "bt709"
                                                                                                                   : "smpte170m";
    for (const json* object : {&stream, &format})
        if (const auto tags = object->find("tags"); tags != object->end() && tags->is_object())
            if (const double mm = numberOf(*tags, "com.apple.quicktime.camera.focal_length.35mm_equivalent"); mm >= 5 && mm <= 1000)
                video.focalLength35Mm = mm;
    return video;
}

Result<VideoAnalysis> analyseVideo(const VideoInfo& video, const VideoWork& work) {
    const double rate = video.durationS > 0 ? std::min(kFramesPerSecond, double(kMaxAnalysed - 1) / video.durationS) : kFramesPerSecond;
    const auto [width, height] = scaledSize(video, std::min(video.widthPx, video.heightPx), kShortSidePx);
    const fs::path raw = work.folder / "small.raw";
    // Half a frame of a 240 Hz video less than the step, so that rounding of time stamps does not skip every other frame.
    const std::string filter =
        formatText("select='isnan(prev_selected_t)+gte(t-prev_selected_t\\,{})',scale={}:{}:flags=area,format=gray,{}", 1 / rate - 0.002,
                   width, height, kPrintTimes);
    std::vector<std::string> arguments = {"ffmpeg", "-hide_banner", "-nostdin", "-loglevel", "error", "-y"};
    const auto input = inputOptions(video.path);
    arguments.insert(arguments.end(), input.begin(), input.end());
    for (const std::string& word :
         {std::string("-map"), std::string("0:V:0"), std::string("-vf"), filter, std::string("-fps_mode"), std::string("passthrough"),
          std::string("-frames:v"), std::to_string(kMaxAnalysed), std::string("-f"), std::string("rawvideo"), raw.string()})
        arguments.push_back(word);
    VideoAnalysis analysis;
    DPL_RETURN_IF_ERROR(runFfmpeg(arguments, video.path, work, kDecodeTimeoutS, [&](std::string_view line) {
        VideoFrame frame;
        if (!parseFrameLine(line, frame) || analysis.frames.size() >= kMaxAnalysed) return;
        analysis.frames.push_back(frame);
        if (work.progress && video.durationS > 0) (void)work.progress(0.6 * std::min(1.0, frame.timeS / video.durationS));
    }));
    const size_t frameBytes = size_t(width) * height;
    std::error_code ignored;
    if (const auto bytes = fs::file_size(raw, ignored); bytes < analysis.frames.size() * frameBytes)  // ffmpeg ends well on a full disk
        return fail(Code::Io,
                    "cannot write frames of {} to {}: {} of {} bytes are there; free some space, or choose another output with -o",
                    video.path.string(), work.folder.string(), bytes, analysis.frames.size() * frameBytes);
    std::ifstream in(raw, std::ios::binary);
    std::vector<uint8_t> grey(frameBytes);
    MotionMeter meter(width, height);
    for (const VideoFrame& frame : analysis.frames) {
        if (!in.read(reinterpret_cast<char*>(grey.data()), std::streamsize(frameBytes))) break;
        analysis.motion.push_back(meter.add(grey, frame.timeS));
        const double share = double(analysis.motion.size()) / double(analysis.frames.size());
        if ((work.cancel && work.cancel->load()) || (work.progress && !work.progress(0.6 + 0.4 * share)))
            return fail(Code::Cancelled, "stopped while reading {}", video.path.string());
    }
    in.close();
    fs::remove(raw, ignored);
    analysis.frames.resize(analysis.motion.size());
    if (analysis.frames.empty())
        return fail(Code::CorruptData, "{}: not one frame can be decoded; copy it again from the phone", video.path.string());
    const double lastS = analysis.frames.back().timeS;
    if (analysis.frames.size() < kMaxAnalysed && video.durationS > 0 && video.durationS - lastS > kCutToleranceS + 2 / rate)
        return fail(Code::CorruptData, "{} says {} s and ends after {} s: it is cut off or damaged; copy it again from the phone",
                    video.path.string(), std::lround(10 * video.durationS) / 10.0, std::lround(10 * lastS) / 10.0);
    return analysis;
}

Result<std::vector<fs::path>> extractFrames(const VideoInfo& video, const std::vector<long long>& pts, uint32_t longSidePx,
                                            const VideoWork& work) {
    if (pts.empty()) return std::vector<fs::path>{};
    std::string select;
    for (long long value : pts) select += formatText("{}eq(pts\\,{})", select.empty() ? "" : "+", value);
    DPL_TRY(const fs::path folder, emptyFolder(work.folder / "frames"));
    size_t written = 0;
    DPL_RETURN_IF_ERROR(writeJpegs(video, {{}, select, pts.size(), 0, folder}, longSidePx, work, [&](const VideoFrame&) {
        if (work.progress) (void)work.progress(std::min(1.0, double(++written) / double(pts.size())));
    }));
    std::vector<fs::path> files;
    std::error_code error;
    for (size_t i = 0; i < pts.size(); ++i) {
        files.push_back(folder / jpegName(i));
        if (!fs::is_regular_file(files.back(), error))
            return fail(Code::CorruptData, "{}: {} of {} chosen frames can be decoded; it is damaged, copy it again from the phone",
                        video.path.string(), i, pts.size());
    }
    return files;
}

Result<std::vector<SampledFrame>> sampleFrames(const VideoInfo& video, size_t count, uint32_t longSidePx, const VideoWork& work) {
    DPL_TRY(const fs::path folder, emptyFolder(work.folder / "sample"));
    std::vector<SampledFrame> frames;
    std::error_code error;
    // ffmpeg may tell of more frames than it writes.
    const auto take = [&](const VideoFrame& frame) {
        if (frames.size() < count) frames.push_back({folder / jpegName(frames.size()), frame.timeS});
    };
    const double stepS = video.durationS / double(count);
    // A little less than the step, so that key frames that lie a step apart all count.
    const std::string apart = formatText("isnan(prev_selected_t)+gte(t-prev_selected_t\\,{})", 0.9 * stepS);
    DPL_RETURN_IF_ERROR(writeJpegs(video, {{"-skip_frame", "nokey"}, apart, count, 0, folder}, longSidePx, work, take));
    if (2 * frames.size() < count && video.durationS > 0) {
        frames.clear();
        for (size_t i = 0; i < count; ++i) {
            const double atS = (double(i) + 0.5) * stepS;
            const size_t number = frames.size();
            const auto takeAt = [&](const VideoFrame&) {
                if (frames.size() == number) frames.push_back({folder / jpegName(number), atS});
            };
            DPL_RETURN_IF_ERROR(writeJpegs(video, {{"-ss", formatText("{}", atS)}, "1", 1, number, folder}, longSidePx, work, takeAt));
            if (work.progress && !work.progress(double(i + 1) / double(count)))
                return fail(Code::Cancelled, "stopped while reading {}", video.path.string());
        }
    }
    std::erase_if(frames, [&](const SampledFrame& frame) { return !fs::is_regular_file(frame.file, error); });
    if (frames.empty())
        return fail(Code::CorruptData, "{}: not one frame can be decoded; copy it again from the phone", video.path.string());
    return frames;
}

}  // namespace dpl
