// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/import.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/base/folder_lock.h"
#include "reconstruction/base/program.h"
#include "reconstruction/input/capture/needed_tools.h"
#include "reconstruction/input/capture/scan_check.h"
#include "reconstruction/input/import/layout.h"
#include "reconstruction/input/import/readers.h"
#include "reconstruction/input/import/write_scan.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMaxKnownPictures = 240;  // recordings with cameras have thousands of frames, most of them neighbours

/** Removes a folder when it goes out of scope. */
struct RemovedFolder {
    fs::path path;
    ~RemovedFolder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

Status checkOutput(const fs::path& out) {
    std::error_code error;
    if (!fs::exists(out, error)) return {};
    if (!fs::is_directory(out, error)) return fail(Code::InvalidArgument, "{} is a file; name a new folder with -o", out.string());
    if (!fs::is_empty(out, error))
        return fail(Code::InvalidArgument, "{} exists already and is not empty; name a new folder with -o, or empty it", out.string());
    return {};
}

Result<Capture> readLayout(const CaptureLayout& layout, const ImportOptions& options, const VideoWork& work) {
    switch (layout.kind) {
        case CaptureKind::ScanFolder:
            return fail(Code::InvalidArgument, "{} is a scan folder already; run doppel reconstruct {} -o OUT", layout.root.string(),
                        shellWord(layout.root));
        case CaptureKind::Nerfstudio:
            return readKnownScan(layout.root);
        case CaptureKind::Colmap:
            return readKnownScan(layout.part.empty() ? layout.root : layout.part);
        case CaptureKind::Neuman:
            return readNeuman(layout.root);
        case CaptureKind::NerfSynthetic:
            return readNerfSynthetic(layout.root);
        case CaptureKind::Polycam:
            return readPolycam(layout.root, layout.part.filename().string());
        case CaptureKind::Record3dFolder:
            return readRecord3d(layout.root);
        case CaptureKind::Record3dFile:
            return readRecord3dFile(layout.root, work.folder / "r3d");
        case CaptureKind::CalibratedVideos:
            return readCalibratedVideos(layout.root, layout.calibration, options.counts, work);
        case CaptureKind::Photos:
            return readPhotos(layout.root, options.longSidePx);
        case CaptureKind::Video:
            break;
    }
    VideoSources sources;
    sources.undivided = layout.root;
    return readVideos(sources, options.counts, options.longSidePx, work);
}

/** Keeps at most kMaxKnownPictures, evenly along the path of the cameras: a metre counts as much as a radian. */
void thinOut(Capture& capture) {
    auto& pictures = capture.pictures;
    if (pictures.size() <= kMaxKnownPictures || !pictures.front().camera || capture.splitStated) return;
    std::vector<double> path(pictures.size(), 0);
    for (size_t i = 1; i < pictures.size(); ++i) {
        const Camerad &a = *pictures[i - 1].camera, &b = *pictures[i].camera;
        const Mat3d turn = glm::transpose(a.viewFromWorldRotation) * b.viewFromWorldRotation;
        const double cosine = std::clamp((turn[0][0] + turn[1][1] + turn[2][2] - 1) / 2, -1.0, 1.0);
        path[i] = path[i - 1] + glm::length(a.eye() - b.eye()) + std::acos(cosine) + 1e-6;
    }
    std::vector<CapturePicture> kept;
    for (size_t i = 0; i < pictures.size(); ++i)
        if (kept.empty() || path[i] >= path.back() * double(kept.size()) / double(kMaxKnownPictures))
            kept.push_back(std::move(pictures[i]));
    capture.notes.push_back(formatText("{} of {} frames are taken, evenly along the path of the camera", kept.size(), pictures.size()));
    pictures = std::move(kept);
}

std::string nextStep(const Scan& scan, const fs::path& out) {
    const std::string lack = missingStillPart(scan);
    if (lack.empty()) {
        const std::string command = formatText("doppel reconstruct {} -o OUT", shellWord(out));
        const std::vector<std::string> missing = missingTools(toolNeeds(scan));
        if (missing.empty()) return formatText("wrote {}; next: {}", out.string(), command);
        return formatText("wrote {}. {}missing: {}; next: doppel setup, then {}", out.string(), describeMissing("An avatar of it", missing),
                          namesOf(missing), command);
    }
    return formatText("wrote {}, which gives no avatar yet: {}. {}", out.string(), lack,
                      scan.camerasKnown
                          ? formatText("Add such pictures to {} as frames of the kind static_full, with cameras of the same world",
                                       (out / "scan.json").string())
                          : std::string("Import such pictures together with these, into another folder"));
}

std::string summaryOf(const Capture& capture) {
    size_t counts[3] = {};
    for (const CapturePicture& picture : capture.pictures) ++counts[size_t(picture.kind)];
    const bool known = capture.pictures.front().camera.has_value();
    std::string text = formatText("read as {}: {} frames ({} still, {} close, {} moving), {}", capture.what, capture.pictures.size(),
                                  counts[0], counts[1], counts[2],
                                  !known                ? "cameras unknown"
                                  : capture.metricWorld ? "cameras in metres"
                                                        : "cameras of unknown scale");
    for (const std::string& note : capture.notes) text += "\n  " + note;
    return text;
}

}  // namespace

Result<ImportReport> importCapture(const ImportOptions& options, const std::atomic<bool>* cancel, const ImportProgress& progress) {
    std::error_code error;
    fs::path out = fs::absolute(options.out, error).lexically_normal();
    if (!out.has_filename()) out = out.parent_path();
    const fs::path target = endOfLinks(out);
    fs::path partial = target;
    partial += ".partial";
    for (fs::directory_iterator at(partial, error), end; !error && at != end; at.increment(error))
        if (const fs::path name = at->path().filename(); name != "scan" && name != "work" && name != FolderLock::kName)
            return fail(Code::InvalidArgument,
                        "{} is not what an interrupted import leaves; move it away, or choose another output with -o", partial.string());
    DPL_RETURN_IF_ERROR(checkOutput(out));
    fs::create_directories(partial, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", partial.string(), error.message());
    DPL_TRY([[maybe_unused]] const FolderLock lock, FolderLock::take(partial, out));
    const RemovedFolder removed{partial};
    DPL_RETURN_IF_ERROR(checkOutput(out));  // once more: another import may have ended since
    for (const char* name : {"scan", "work"}) {
        fs::remove_all(partial / name, error);
        fs::create_directory(partial / name, error);
        if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", (partial / name).string(), error.message());
    }

    constexpr double kReading = 0.8;  // share of the time: videos are decoded twice before their frames are written
    VideoWork work{partial / "work", cancel, [&](double share) { return !progress || progress(kReading * share, "reading videos"); }};
    Capture capture;
    const bool named = !options.videos.still.empty() || !options.videos.closeup.empty() || !options.videos.moving.empty();
    if (named) {
        DPL_TRY(capture, readVideos(options.videos, options.counts, options.longSidePx, work));
    } else {
        DPL_TRY(const CaptureLayout layout, recogniseCapture(options.source));
        DPL_TRY(capture, readLayout(layout, options, work));
        capture.notes.insert(capture.notes.begin(), layout.notes.begin(), layout.notes.end());
    }
    if (capture.pictures.empty()) return fail(Code::CorruptData, "the capture has no picture");
    thinOut(capture);
    DPL_RETURN_IF_ERROR(
        writeScan(capture, out.filename().string(), options.heightM, partial / "scan", [&](double share, const std::string& what) {
            if (cancel && cancel->load()) return false;
            return !progress || progress(kReading + (1 - kReading) * share, what);
        }));
    DPL_TRY(const Scan scan, readScan(partial / "scan", ScanCameras::MayLack));
    if (fs::exists(target, error)) fs::remove(target, error);
    fs::rename(partial / "scan", target, error);
    if (error) return fail(Code::Io, "cannot write {}: {}; choose another output with -o", out.string(), error.message());
    return ImportReport{summaryOf(capture), nextStep(scan, out)};
}

}  // namespace dpl
