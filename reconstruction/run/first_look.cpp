// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/first_look.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/image_file.h"
#include "reconstruction/base/models_folder.h"
#include "reconstruction/base/program.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/video.h"
#include "reconstruction/input/observe/observations.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/jobs.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr size_t kStill = 36, kCloseup = 16, kMoving = 24;
constexpr uint32_t kLongSidePx = 960;  // a blur of two pixels of a phone's video still shows
constexpr double kLookingS = 60;       // after which no further picture is shown to the networks

struct Source {
    FrameKind kind;
    size_t film;
    double timeS;
    fs::path file;
};

/** A new folder in the system's temporary folder, which others can neither foresee nor enter. It goes with this object. */
struct TemporaryFolder {
    fs::path path;
    static Result<TemporaryFolder> make() {
        std::string name = (fs::temp_directory_path() / "doppel-look-XXXXXX").string();
        if (!::mkdtemp(name.data())) return fail(Code::Io, "cannot create {}: {}", name, std::strerror(errno));
        return TemporaryFolder{name};
    }
    explicit TemporaryFolder(fs::path made) : path(std::move(made)) {}
    TemporaryFolder(TemporaryFolder&& other) noexcept : path(std::exchange(other.path, {})) {}
    ~TemporaryFolder() {
        std::error_code ignored;
        if (!path.empty()) fs::remove_all(path, ignored);
    }
};

Status addVideos(const std::vector<fs::path>& videos, FrameKind kind, size_t count, const VideoWork& work, std::vector<Source>& sources) {
    for (const fs::path& path : videos) {
        VideoWork own = work;
        own.folder = work.folder / std::to_string(sources.size());
        std::error_code error;
        fs::create_directories(own.folder, error);
        if (error) return fail(Code::Io, "cannot create {}: {}", own.folder.string(), error.message());
        DPL_TRY(const VideoInfo video, probeVideo(path, own));
        DPL_TRY(const auto frames, sampleFrames(video, std::max<size_t>(1, count / videos.size()), kLongSidePx, own));
        const size_t film = sources.size();
        for (const SampledFrame& frame : frames) sources.push_back({kind, film, frame.timeS, frame.file});
    }
    return {};
}

/** The pictures of one kind, thinned out evenly. */
void addFrames(const Scan& scan, FrameKind kind, size_t count, std::vector<Source>& sources) {
    std::vector<size_t> frames;
    for (size_t f = 0; f < scan.frames.size(); ++f)
        if (scan.frames[f].kind == kind) frames.push_back(f);
    for (const size_t f : evenlySpaced(frames, count)) {
        const ScanFrame& frame = scan.frames[f];
        sources.push_back({kind, size_t(kind), frame.timeS > 0 ? frame.timeS : double(f), frame.imagePath});
    }
}

/** Every picture measured, by the networks too where there are any, in an order in which early ones are spread over the film. */
Result<std::vector<FilmPicture>> measure(const std::vector<Source>& sources, const fs::path& models, Jobs& jobs, Progress& progress) {
    std::vector<size_t> order;
    for (const size_t begin : {0, 2, 1, 3})
        for (size_t i = begin; i < sources.size(); i += 4) order.push_back(i);
    std::vector<FilmPicture> pictures(sources.size());
    std::vector<Status> failures(sources.size());
    std::vector<std::optional<Observer>> observers(jobs.threadCount());
    const auto start = std::chrono::steady_clock::now();
    std::atomic<size_t> done{0};
    jobs.forBlocks(order.size(), [&](size_t at, uint32_t worker) {
        const size_t i = order[at];
        if (Progress::cancelled()) return;
        const auto work = [&]() -> Status {
            DPL_TRY(const auto bytes, readCompleteImage(sources[i].file));
            DPL_TRY(Picture picture, decodePicture(bytes, PictureChannels::Rgb));
            const ImageRgb8 image{picture.widthPx, picture.heightPx, std::move(picture.pixels)};
            const bool inTime = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < kLookingS;
            std::optional<Glance> glance;
            if (!models.empty() && inTime) {
                if (!observers[worker]) {
                    DPL_TRY(observers[worker], Observer::load(models));
                }
                DPL_TRY(glance, observers[worker]->glance(image));
            }
            pictures[i] = measureFilmPicture(image, sources[i].kind, sources[i].film, sources[i].timeS, glance ? &*glance : nullptr);
            return {};
        };
        failures[i] = work();
        const size_t count = ++done;
        if (worker == 0) progress.update(double(count) / double(order.size()), formatText("{} pictures", order.size()));
    });
    if (Progress::cancelled()) return fail(Code::Cancelled, "stopped");
    for (const Status& failure : failures) DPL_RETURN_IF_ERROR(failure);
    return pictures;
}

bool isVideoFile(const fs::path& path) {
    std::error_code error;
    const std::string ending = lowerExtension(path);
    return fs::is_regular_file(path, error) &&
           std::ranges::any_of(kVideoEndings, [&](const VideoEnding& known) { return ending == known.extension; });
}

}  // namespace

std::string FirstLook::text() const {
    std::string text = formatText("First look, at {} pictures{}: ", pictures,
                                  withNetworks ? ""
                                               : ", without the networks, which see missing sides, cut feet, hands and other people "
                                                 "(doppel setup installs them)");
    if (faults.empty()) return text + "nothing is wrong with them";
    text += "to film again, while the person is still there";
    for (size_t i = 0; i < faults.size(); ++i) text += formatText("\n  {}. {}", i + 1, faults[i].sentence);
    return text;
}

Result<std::optional<FirstLook>> takeFirstLook(const ReconstructOptions& options, Progress& progress) {
    VideoSources videos = options.videos;
    std::optional<Scan> scan;
    if (isVideoFile(options.scan)) {
        videos.undivided = options.scan;
    } else if (!options.scan.empty()) {
        std::error_code error;
        if (!fs::exists(options.scan / "scan.json", error)) return std::optional<FirstLook>();
        auto read = readScan(options.scan, ScanCameras::MayLack);
        if (!read || read->camerasKnown) return std::optional<FirstLook>();  // the long check names what is wrong, or is quick
        scan = std::move(*read);
    }
    if (!scan && !(findProgram("ffmpeg") && findProgram("ffprobe")))
        return std::optional<FirstLook>();  // the long check names all that lacks
    progress.beginStage("first look");
    DPL_TRY(const TemporaryFolder temporary, TemporaryFolder::make());
    const VideoWork work{temporary.path, &Progress::cancelFlag(), {}};
    std::vector<Source> sources;
    if (scan) {
        addFrames(*scan, FrameKind::StaticFull, kStill, sources);
        addFrames(*scan, FrameKind::StaticCloseup, kCloseup, sources);
        addFrames(*scan, FrameKind::Dynamic, kMoving, sources);
    } else if (!videos.undivided.empty()) {
        DPL_RETURN_IF_ERROR(addVideos({videos.undivided}, FrameKind::StaticFull, kStill + kMoving, work, sources));
    } else {
        DPL_RETURN_IF_ERROR(addVideos(videos.still, FrameKind::StaticFull, kStill, work, sources));
        DPL_RETURN_IF_ERROR(addVideos(videos.closeup, FrameKind::StaticCloseup, kCloseup, work, sources));
        DPL_RETURN_IF_ERROR(addVideos(videos.moving, FrameKind::Dynamic, kMoving, work, sources));
    }
    if (sources.empty()) return std::optional<FirstLook>();
    const fs::path models = options.models.empty() ? installedModels() : options.models;
    Jobs jobs(options.threadCount);
    DPL_TRY(const std::vector<FilmPicture> pictures, measure(sources, models, jobs, progress));
    FirstLook look{pictures.size(), !models.empty(), filmFaults(pictures, !videos.undivided.empty())};
    progress.endStage(formatText("{} pictures", look.pictures));
    return std::optional(std::move(look));
}

}  // namespace dpl
