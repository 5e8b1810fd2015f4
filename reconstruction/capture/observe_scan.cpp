// SPDX-License-Identifier: Apache-2.0
// Observes all frames of a scan and writes the results as files in the layout of a scan folder.
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "reconstruction/capture/observations.h"
#include "reconstruction/image/image_codec.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

Status writeFile(const fs::path& path, std::span<const uint8_t> bytes) {
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    return writeFileAtomically(path, bytes);
}

Status writePng(const fs::path& path, const ImageGrey8& image) {
    DPL_TRY(const auto bytes, encodePng(image.pixels, image.widthPx, image.heightPx, 1));
    return writeFile(path, bytes);
}

Status writeKeypoints(const fs::path& path, const ScanFrame& frame, const std::vector<Keypoint>& keypoints) {
    nlohmann::ordered_json file;
    file["image"] = frame.name;
    file["names"] = nlohmann::ordered_json::array();
    file["detections"] = nlohmann::ordered_json::array();
    file["confidence"] = nlohmann::ordered_json::array();
    const auto names = observedKeypointNames();
    for (size_t k = 0; k < keypoints.size(); ++k) {
        file["names"].push_back(std::string(names[k]));
        file["detections"].push_back({std::round(keypoints[k].px.x * 1000) / 1000, std::round(keypoints[k].px.y * 1000) / 1000});
        file["confidence"].push_back(std::round(keypoints[k].confidence * 1000) / 1000);
    }
    const std::string text = file.dump() + "\n";
    return writeFile(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

/** The observations that the scan lacks for one frame. */
struct Wanted {
    bool keypoints = false, labels = false, mask = false;
    bool any() const { return keypoints || labels || mask; }
};

Wanted wantedOf(const Scan& scan, const ScanFrame& frame) {
    return {scan.keypointNames.empty(), frame.labelsPath.empty(), frame.maskPath.empty()};
}

/** Paths of one frame's files in an output folder. */
struct FramePaths {
    fs::path keypoints, labels, mask;
    FramePaths(const fs::path& folder, const ScanFrame& frame)
        : keypoints(folder / "keypoints" / (frame.name + ".json")),
          labels(folder / "labels" / (frame.name + ".png")),
          mask(folder / "masks" / (frame.name + ".png")) {}
};

/** Writes no label picture when no person was found. */
Status observeFrame(Observer& observer, const ScanFrame& frame, const Wanted& want, const fs::path& output) {
    // The networks get the stored, distorted pixels, because the files of a scan hold positions in stored pixels. The readers undistort.
    ScanFrame stored = frame;
    stored.lens = {};
    DPL_TRY(const ImageRgb8 image, readFrameImage(stored));
    std::optional<ImageGrey8> mask;
    if (!frame.maskPath.empty()) {
        DPL_TRY(mask, readFrameMask(stored));
    }
    DPL_TRY(const Observation seen, observer.observe(image, mask ? &*mask : nullptr));
    const FramePaths paths(output, frame);
    if (want.keypoints) DPL_CHECK_OK(writeKeypoints(paths.keypoints, frame, seen.keypoints));
    if (want.mask) DPL_CHECK_OK(writePng(paths.mask, seen.mask));
    if (want.labels && !seen.labels.pixels.empty()) DPL_CHECK_OK(writePng(paths.labels, seen.labels));
    return {};
}

}  // namespace

Status observeScan(const Scan& scan, const ObserveOptions& options, Jobs& jobs) {
    std::vector<std::optional<Observer>> observers(jobs.threadCount());
    for (auto& observer : observers) {
        DPL_TRY(observer, Observer::load(options.models));
    }
    std::vector<Status> results(scan.frames.size());
    std::mutex progressLock;
    size_t done = 0;
    jobs.forBlocks(scan.frames.size(), [&](size_t i, uint32_t worker) {
        const ScanFrame& frame = scan.frames[i];
        Wanted want = wantedOf(scan, frame);
        want.labels = want.labels && observers[worker]->hasLabels();
        if (want.any()) results[i] = observeFrame(*observers[worker], frame, want, options.output);
        if (!options.progress) return;
        const std::lock_guard lock(progressLock);
        options.progress(++done, scan.frames.size());
    });
    for (const auto& result : results) DPL_CHECK_OK(result);
    return {};
}

Scan withObservations(Scan scan, const fs::path& folder) {
    bool newLabels = false;
    for (ScanFrame& frame : scan.frames) {
        const Wanted want = wantedOf(scan, frame);
        const FramePaths made(folder, frame);
        const auto take = [](bool wanted, const fs::path& from, fs::path& to) {
            std::error_code error;
            if (!wanted || !fs::is_regular_file(from, error)) return false;
            to = from;
            return true;
        };
        take(want.keypoints, made.keypoints, frame.keypointsPath);
        take(want.mask, made.mask, frame.maskPath);
        newLabels |= take(want.labels, made.labels, frame.labelsPath);
    }
    if (scan.keypointNames.empty())
        for (const auto name : observedKeypointNames()) scan.keypointNames.emplace_back(name);
    if (newLabels && scan.labels.empty())
        scan.labels = {{"background", 0}, {"body", 1}, {"top", 2}, {"bottom", 3}, {"hair", 4}, {"shoes", 5}};
    return scan;
}

}  // namespace dpl
