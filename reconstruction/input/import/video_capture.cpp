// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/video_capture.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "reconstruction/base/json_fields.h"
#include "reconstruction/base/program.h"
#include "reconstruction/input/capture/needed_tools.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/calibration.h"
#include "reconstruction/input/import/exif.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/readers.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr double kGapS = 1;                  // between the times of two videos of motion
constexpr double kAlmostSameSize = 0.01;     // a picture this near to the calibrated size was cropped or padded, not scaled
constexpr uint32_t kAnySidePx = UINT32_MAX;  // calibrated videos keep their size

double tenths(double value) {
    return std::round(10 * value) / 10;
}

/** A folder of its own for each video, with the progress of its share of the whole. */
class VideoSteps {
public:
    VideoSteps(const VideoWork& work, size_t videos) : work_(work), videos_(videos) {}
    VideoWork next() {
        VideoWork part = work_;
        const size_t index = done_++;
        part.folder = work_.folder / std::to_string(index);
        std::error_code ignored;
        fs::create_directories(part.folder, ignored);
        return part;
    }
    /** Analysis is most of the work; extraction decodes once more without measuring. */
    void report(VideoWork& part, double from, double to) const {
        const double begin = double(done_ - 1);
        part.progress = [this, begin, from, to](double share) {
            return !work_.progress || work_.progress((begin + from + (to - from) * share) / double(videos_));
        };
    }

private:
    const VideoWork& work_;
    size_t videos_, done_ = 0;
};

struct Taken {
    FrameKind kind;
    double timeS;
    fs::path image;
};

/** Says what of a video is not as it is stored, or left. */
void noteStreams(const VideoInfo& video, std::vector<std::string>& notes) {
    const std::string name = video.path.filename().string();
    if (video.widthPx != video.storedWidthPx || video.heightPx != video.storedHeightPx)
        notes.push_back(formatText("{} has {} x {} pixels that are not square; its frames are stretched to {} x {}", name,
                                   video.storedWidthPx, video.storedHeightPx, video.widthPx, video.heightPx));
    if (video.otherStreams > 0)
        notes.push_back(
            formatText("{} holds {} more video streams, which are left out. To take the second one, copy it: ffmpeg -i {} -map "
                       "0:V:1 -c copy second.mkv",
                       name, video.otherStreams, shellWord(video.path)));
}

class VideoReader {
public:
    VideoReader(const FrameCounts& counts, uint32_t longSidePx, const VideoWork& work, size_t videos)
        : counts_(counts), longSidePx_(longSidePx), steps_(work, videos) {}

    /** Takes frames of one video. `kind` says what it shows; nothing: both, to be found. `videos`: how many share the frames of this kind.
     */
    Status add(const fs::path& path, std::optional<FrameKind> kind, size_t videos) {
        VideoWork part = steps_.next();
        DPL_TRY(const VideoInfo info, probeVideo(path, part));
        steps_.report(part, 0, 0.6);
        DPL_TRY(const VideoAnalysis analysis, analyseVideo(info, part));
        const FrameSpan all{0, analysis.frames.size()};
        StillAndMoving parts{all, {}};
        if (!kind) {
            parts = splitByMotion(analysis.motion);
            noteSplit(path, analysis, parts);
        }
        std::vector<std::pair<size_t, FrameKind>> chosen;
        const auto choose = [&](FrameSpan span, FrameKind of) {
            const size_t most = of == FrameKind::StaticFull      ? counts_.still
                                : of == FrameKind::StaticCloseup ? counts_.closeup
                                                                 : counts_.moving;
            for (size_t i : chooseFrames(analysis.motion, span, std::max<size_t>(1, most / videos), of == FrameKind::Dynamic))
                chosen.emplace_back(i, of);
        };
        if (kind) {
            choose(all, *kind);
        } else {
            choose(parts.still, FrameKind::StaticFull);
            choose(parts.moving, FrameKind::Dynamic);
        }
        std::sort(chosen.begin(), chosen.end());
        std::vector<long long> pts;
        for (const auto& [index, of] : chosen) pts.push_back(analysis.frames[index].pts);
        steps_.report(part, 0.6, 1);
        DPL_TRY(const auto files, extractFrames(info, pts, longSidePx_, part));
        for (size_t i = 0; i < chosen.size(); ++i) {
            const FrameKind of = chosen[i].second;
            const double timeS = analysis.frames[chosen[i].first].timeS;
            taken_.push_back({of, of == FrameKind::Dynamic ? startS_ + timeS : 0, files[i]});
        }
        if (!kind || *kind == FrameKind::Dynamic) startS_ += analysis.frames.back().timeS + kGapS;
        noteStreams(info, notes_);
        if (info.hdr) notes_.push_back(formatText("{} is HDR and was tone-mapped to 8-bit sRGB", path.filename().string()));
        if (info.focalLength35Mm > 0) {
            const double factor = std::min(1.0, double(longSidePx_) / std::max(info.widthPx, info.heightPx));
            focalPx_ = factor * focalFrom35Mm(info.focalLength35Mm, info.widthPx, info.heightPx);
        }
        return {};
    }

    Capture finish() {
        Capture capture;
        capture.what = "video";
        capture.metricWorld = false;
        capture.focalGuessPx = focalPx_;
        capture.notes = std::move(notes_);
        size_t next[3] = {};
        for (FrameKind kind : {FrameKind::StaticFull, FrameKind::StaticCloseup, FrameKind::Dynamic})
            for (const Taken& taken : taken_) {
                if (taken.kind != kind) continue;
                CapturePicture picture;
                picture.name = frameName(kind, next[size_t(kind)]++);
                picture.kind = kind;
                picture.image = taken.image;
                picture.timeS = taken.timeS;
                capture.pictures.push_back(std::move(picture));
            }
        return capture;
    }

private:
    void noteSplit(const fs::path& path, const VideoAnalysis& analysis, const StillAndMoving& parts) {
        const auto span = [&](FrameSpan s) {
            return formatText("{} to {} s", tenths(analysis.frames[s.begin].timeS), tenths(analysis.frames[s.end - 1].timeS));
        };
        const std::string name = path.filename().string();
        if (!parts.followed)
            notes_.push_back(
                formatText("{}: its frames lie too far apart to tell a still subject from a moving one, so all count as still; cut the "
                           "video and use --static and --motion",
                           name));
        else if (parts.cameraRests)
            notes_.push_back(
                formatText("{}: the camera rests all the time, so all of it counts as motion. The shape needs a walk round a "
                           "subject that stands still",
                           name));
        else if (parts.still.end == parts.still.begin)
            notes_.push_back(
                formatText("{}: the subject moves all the time. A walk round a subject that stands still makes a better scan", name));
        else if (parts.moving.end == parts.moving.begin)
            notes_.push_back(formatText("{}: the subject stands still all the time, so the avatar learns nothing of motion", name));
        else
            notes_.push_back(
                formatText("{}: the subject stands still from {} and moves from {}. If that is wrong, cut the video and use --static "
                           "and --motion",
                           name, span(parts.still), span(parts.moving)));
    }

    FrameCounts counts_;
    uint32_t longSidePx_;
    VideoSteps steps_;
    std::vector<Taken> taken_;
    std::vector<std::string> notes_;
    double startS_ = 0, focalPx_ = 0;
};

/** The camera for pictures of the video's size. A calibration of pixels that are not square keeps them: fx and fy differ. */
Status fitToVideo(Camerad& camera, VideoInfo& video, const std::string& name) {
    const auto shapeIs = [&](double width, double height) {
        return std::abs(width / height * double(camera.heightPx) / double(camera.widthPx) - 1) <= kAlmostSameSize;
    };
    if (!shapeIs(video.widthPx, video.heightPx) && shapeIs(video.storedWidthPx, video.storedHeightPx))
        video.widthPx = video.storedWidthPx, video.heightPx = video.storedHeightPx;
    const double sx = double(video.widthPx) / double(camera.widthPx), sy = double(video.heightPx) / double(camera.heightPx);
    if (std::abs(sx - 1) > kAlmostSameSize || std::abs(sy - 1) > kAlmostSameSize) {
        if (std::abs(sx / sy - 1) > kAlmostSameSize)
            return fail(Code::CorruptData, "{} is {} x {} pixels, the calibration of camera '{}' says {} x {}, which is another shape",
                        video.path.string(), video.widthPx, video.heightPx, name, camera.widthPx, camera.heightPx);
        camera.fx *= sx, camera.cx *= sx, camera.fy *= sy, camera.cy *= sy;
    }
    camera.widthPx = video.widthPx, camera.heightPx = video.heightPx;
    return {};
}

/** The one video whose name contains the camera's. */
Result<fs::path> videoOf(const std::string& camera, const std::vector<fs::path>& videos, const fs::path& folder) {
    const fs::path* found = nullptr;
    for (const fs::path& video : videos) {
        if (video.stem().string().find(camera) == std::string::npos) continue;
        if (found)
            return fail(Code::InvalidArgument, "{}: {} and {} both belong to camera '{}'; keep one take in the folder", folder.string(),
                        found->filename().string(), video.filename().string(), camera);
        found = &video;
    }
    if (!found)
        return fail(Code::NotFound, "{}: no video's name contains that of camera '{}'; rename the videos after their cameras",
                    folder.string(), camera);
    return *found;
}

/** Refuses videos on a machine that cannot read them, and names all that an avatar of them will need besides. */
Status checkVideoTools(bool camerasKnown) {
    if (missingTools({.videos = true}).empty()) return {};
    return fail(Code::NotFound, "{}then run the same command again",
                describeMissing("the film", missingTools({.videos = true, .keypoints = true, .masks = true, .cameras = !camerasKnown})));
}

/** Checks all paths before the first video is decoded, which takes a while. */
Status checkNamed(const VideoSources& sources) {
    std::error_code error;
    std::vector<std::pair<fs::path, const char*>> before;
    for (const auto& [list, option] :
         {std::pair{&sources.still, "--static"}, {&sources.closeup, "--closeup"}, {&sources.moving, "--motion"}})
        for (const fs::path& path : *list) {
            if (!fs::is_regular_file(path, error)) return fail(Code::NotFound, "{}: no such video", path.string());
            if (isPicture(path) || isHeic(path))
                return fail(Code::InvalidArgument,
                            "{} is a photo, and {} takes videos; photos are imported by their folder: doppel import {} -o scan",
                            path.string(), option, shellWord(path.has_parent_path() ? path.parent_path() : fs::path(".")));
            for (const auto& [other, at] : before)
                if (fs::equivalent(path, other, error))
                    return fail(Code::InvalidArgument, "{} is given twice ({} and {}); name each video once", path.string(), at, option);
            before.emplace_back(path, option);
        }
    return {};
}

}  // namespace

Result<Capture> readVideos(const VideoSources& sources, const FrameCounts& counts, uint32_t longSidePx, const VideoWork& work) {
    DPL_RETURN_IF_ERROR(checkNamed(sources));
    DPL_RETURN_IF_ERROR(checkVideoTools(/*camerasKnown=*/false));
    const bool one = !sources.undivided.empty();
    VideoReader reader(counts, longSidePx, work, one ? 1 : sources.still.size() + sources.closeup.size() + sources.moving.size());
    if (one) DPL_RETURN_IF_ERROR(reader.add(sources.undivided, std::nullopt, 1));
    for (const auto& [list, kind] : {std::pair{&sources.still, FrameKind::StaticFull},
                                     {&sources.closeup, FrameKind::StaticCloseup},
                                     {&sources.moving, FrameKind::Dynamic}})
        for (const fs::path& path : *list) DPL_RETURN_IF_ERROR(reader.add(path, kind, list->size()));
    return reader.finish();
}

Result<Capture> readCalibratedVideos(const fs::path& folder, const fs::path& calibration, const FrameCounts& counts,
                                     const VideoWork& work) {
    DPL_TRY(const auto cameras, readCalibration(calibration));
    DPL_RETURN_IF_ERROR(checkVideoTools(/*camerasKnown=*/true));
    const std::vector<fs::path> videos = videosIn(folder);
    Capture capture;
    capture.what = calibration.extension() == ".toml" ? "videos with a Pose2Sim calibration" : "videos with a Qualisys calibration";
    VideoSteps steps(work, cameras.size());
    std::vector<double> times;  // chosen in the first video
    LeftOut without;
    std::set<fs::path> taken;
    for (const CalibratedCamera& calibrated : cameras) {
        const auto found = videoOf(calibrated.name, videos, folder);
        if (!found) {
            if (found.error().code != Code::NotFound) return found.error();
            without.add(calibrated.name, found.error());
            continue;
        }
        const fs::path& path = *found;
        taken.insert(path);
        VideoWork part = steps.next();
        DPL_TRY(VideoInfo info, probeVideo(path, part));
        Camerad camera = calibrated.camera;
        DPL_RETURN_IF_ERROR(fitToVideo(camera, info, calibrated.name));
        noteStreams(info, capture.notes);
        steps.report(part, 0, 0.6);
        DPL_TRY(const VideoAnalysis analysis, analyseVideo(info, part));
        if (times.empty())
            for (size_t i :
                 chooseFrames(analysis.motion, {0, analysis.frames.size()}, std::max<size_t>(1, counts.moving / cameras.size()), true))
                times.push_back(analysis.frames[i].timeS);
        std::vector<long long> pts;
        std::vector<double> stamps;
        for (double time : times) {
            const auto nearest = std::min_element(
                analysis.frames.begin(), analysis.frames.end(),
                [&](const VideoFrame& a, const VideoFrame& b) { return std::abs(a.timeS - time) < std::abs(b.timeS - time); });
            if (!pts.empty() && pts.back() == nearest->pts) continue;  // this video is shorter
            pts.push_back(nearest->pts), stamps.push_back(time);
        }
        if (pts.size() < times.size()) capture.notes.push_back(formatText("{} is shorter than the first video", path.filename().string()));
        steps.report(part, 0.6, 1);
        DPL_TRY(const auto files, extractFrames(info, pts, kAnySidePx, part));
        for (size_t i = 0; i < files.size(); ++i) {
            CapturePicture picture;
            picture.kind = FrameKind::Dynamic;
            picture.name = nameFromPath(formatText("dyn_{}_{}", calibrated.name, i));
            picture.image = files[i];
            picture.camera = camera;
            picture.lens = calibrated.lens;
            picture.timeS = stamps[i];
            capture.pictures.push_back(std::move(picture));
        }
    }
    DPL_RETURN_IF_ERROR(without.check(taken.size()));
    if (!without.empty()) capture.notes.push_back(without.sentence(cameras.size(), "cameras"));
    for (const fs::path& video : videos)
        if (taken.count(video) == 0)
            capture.notes.push_back(formatText("{} is left out: its name contains that of no camera", video.filename().string()));
    return capture;
}

}  // namespace dpl
