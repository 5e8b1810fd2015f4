// SPDX-License-Identifier: Apache-2.0
// Observations for a whole scan, as files in the layout of our scan folders.
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
    file["xy_noisy"] = nlohmann::ordered_json::array();
    file["confidence"] = nlohmann::ordered_json::array();
    const auto names = observedKeypointNames();
    for (size_t k = 0; k < keypoints.size(); ++k) {
        file["names"].push_back(std::string(names[k]));
        file["xy_noisy"].push_back({std::round(keypoints[k].px.x * 1000) / 1000, std::round(keypoints[k].px.y * 1000) / 1000});
        file["confidence"].push_back(std::round(keypoints[k].confidence * 1000) / 1000);
    }
    const std::string text = file.dump() + "\n";
    return writeFile(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

struct Wanted {
    bool keypoints = false, labels = false, mask = false;
    bool any() const { return keypoints || labels || mask; }
};

/** want.labels is cleared when nobody was found: no label picture is better than an empty one. */
Status observeFrame(Observer& observer, const ScanFrame& frame, Wanted& want, const fs::path& output) {
    // The networks look at the picture as stored, lens distortion and all, because files of a scan speak of stored pixels; the reader
    // takes the lens out of everything alike.
    ScanFrame stored = frame;
    stored.lens = {};
    DPL_TRY(const ImageRgb8 image, readFrameImage(stored));
    std::optional<ImageGrey8> mask;
    if (!frame.maskPath.empty()) {
        DPL_TRY(mask, readFrameMask(stored));
    }
    DPL_TRY(const Observation seen, observer.observe(image, mask ? &*mask : nullptr));
    if (want.keypoints) DPL_CHECK_OK(writeKeypoints(output / "keypoints" / (frame.name + ".json"), frame, seen.keypoints));
    if (want.mask) DPL_CHECK_OK(writePng(output / "masks" / (frame.name + ".png"), seen.mask));
    want.labels = want.labels && !seen.labels.pixels.empty();
    if (want.labels) DPL_CHECK_OK(writePng(output / "labels" / (frame.name + ".png"), seen.labels));
    return {};
}

}  // namespace

Status observeScan(Scan& scan, const ObserveOptions& options, Jobs& jobs) {
    const bool wantKeypoints = scan.keypointNames.empty();
    std::vector<std::optional<Observer>> observers(jobs.threadCount());
    DPL_TRY(observers[0], Observer::load(options.models));
    const bool labelsPossible = observers[0]->hasLabels();
    for (size_t i = 1; i < observers.size(); ++i) {
        DPL_TRY(observers[i], Observer::load(options.models));
    }
    std::vector<Wanted> wanted;
    for (const auto& frame : scan.frames)
        wanted.push_back({wantKeypoints, labelsPossible && frame.labelsPath.empty(), frame.maskPath.empty()});
    std::vector<Status> results(scan.frames.size());
    std::mutex progressLock;
    size_t done = 0;
    jobs.forBlocks(scan.frames.size(), [&](size_t i, uint32_t worker) {
        if (wanted[i].any()) results[i] = observeFrame(*observers[worker], scan.frames[i], wanted[i], options.output);
        if (!options.progress) return;
        const std::lock_guard lock(progressLock);
        options.progress(++done, scan.frames.size());
    });
    for (const auto& result : results) DPL_CHECK_OK(result);
    if (wantKeypoints)
        for (const auto name : observedKeypointNames()) scan.keypointNames.emplace_back(name);
    bool newLabels = false;
    for (size_t i = 0; i < scan.frames.size(); ++i) {
        ScanFrame& frame = scan.frames[i];
        if (wanted[i].keypoints) frame.keypointsPath = options.output / "keypoints" / (frame.name + ".json");
        if (wanted[i].labels) frame.labelsPath = options.output / "labels" / (frame.name + ".png"), newLabels = true;
        if (wanted[i].mask) frame.maskPath = options.output / "masks" / (frame.name + ".png");
    }
    if (newLabels && scan.labels.empty())
        scan.labels = {{"background", 0}, {"body", 1}, {"top", 2}, {"bottom", 3}, {"hair", 4}, {"shoes", 5}};
    return {};
}

}  // namespace dpl
