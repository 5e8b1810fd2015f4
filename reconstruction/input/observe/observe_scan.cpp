// SPDX-License-Identifier: Apache-2.0
// Observes all frames of a scan and writes the results as files in the layout of a scan folder.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/input/observe/observations.h"
#include "reconstruction/input/observe/person_places.h"
#include "sdk/core/files.h"
#include "sdk/core/task.h"

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

Status writeKeypoints(const fs::path& path, const ScanFrame& frame, const Observation& seen) {
    nlohmann::ordered_json file;
    file["image"] = frame.name;
    file["names"] = nlohmann::ordered_json::array();
    file["detections"] = nlohmann::ordered_json::array();
    file["confidence"] = nlohmann::ordered_json::array();
    const auto add = [&](std::span<const std::string_view> names, const std::vector<Keypoint>& keypoints) {
        for (size_t k = 0; k < keypoints.size(); ++k) {
            file["names"].push_back(std::string(names[k]));
            file["detections"].push_back({std::round(keypoints[k].px.x * 1000) / 1000, std::round(keypoints[k].px.y * 1000) / 1000});
            file["confidence"].push_back(std::round(keypoints[k].confidence * 1000) / 1000);
        }
    };
    add(observedKeypointNames(), seen.keypoints);
    add(handKeypointNames(), seen.hands);
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

/** The networks get the stored, distorted pixels, because the files of a scan hold positions in stored pixels. The readers undistort. */
ScanFrame asStored(const ScanFrame& frame) {
    ScanFrame stored = frame;
    stored.lens = {};
    return stored;
}

/** Writes no label picture when no person was found. `start`: where the person is; may be null. */
Status observeFrame(Observer& observer, const ScanFrame& frame, const Wanted& want, const PersonCrop* start, const fs::path& output) {
    const ScanFrame stored = asStored(frame);
    DPL_TRY(const ImageRgb8 image, readFrameImage(stored));
    std::optional<ImageGrey8> mask;
    if (!frame.maskPath.empty()) {
        DPL_TRY(mask, readFrameMask(stored));
    }
    DPL_TRY(const Observation seen, observer.observe(image, mask ? &*mask : nullptr, start, frame.kind == FrameKind::StaticCloseup));
    const FramePaths paths(output, frame);
    if (want.keypoints) DPL_RETURN_IF_ERROR(writeKeypoints(paths.keypoints, frame, seen));
    if (want.mask) DPL_RETURN_IF_ERROR(writePng(paths.mask, seen.mask));
    if (want.labels && !seen.labels.pixels.empty()) DPL_RETURN_IF_ERROR(writePng(paths.labels, seen.labels));
    return {};
}

bool isChosenAt(const Whereabouts& where, const Vec2d& px) {
    if (where.chosen == kNobody) return false;
    const PersonBox& box = where.people[where.chosen].box;
    return px.x >= box.low.x && px.y >= box.low.y && px.x <= box.high.x && px.y <= box.high.y;
}

}  // namespace

bool lacksObservations(const Scan& scan) {
    return scan.keypointNames.empty() ||
           std::any_of(scan.frames.begin(), scan.frames.end(), [](const ScanFrame& frame) { return frame.maskPath.empty(); });
}

Result<PersonPoint> parsePersonPoint(const std::string& text) {
    const size_t colon = text.rfind(':');
    PersonPoint point;
    char rest = 0;
    if (colon == std::string::npos || colon == 0 ||
        std::sscanf(text.c_str() + colon + 1, "%lf,%lf%c", &point.px.x, &point.px.y, &rest) != 2 ||
        !(std::abs(point.px.x) < 1e6 && std::abs(point.px.y) < 1e6))
        return fail(Code::InvalidArgument, "--person {}: write FRAME:X,Y, for example full_000:190,250", text);
    point.frame = text.substr(0, colon);
    return point;
}

Status observeScan(const Scan& scan, const ObserveOptions& options, Jobs& jobs) {
    std::vector<std::optional<Observer>> observers(jobs.threadCount());
    for (auto& observer : observers) {
        DPL_TRY(observer, Observer::load(options.models));
    }
    for (const PersonPoint& point : options.persons) {
        const auto named = std::find_if(scan.frames.begin(), scan.frames.end(), [&](const ScanFrame& f) { return f.name == point.frame; });
        if (named == scan.frames.end())
            return fail(Code::InvalidArgument, "--person {}: the scan has no such frame; name one of its pictures", point.frame);
        if (named->split == Split::Test)
            return fail(Code::InvalidArgument, "--person {}: this frame is held out; name a training frame", point.frame);
    }
    if (options.note && scan.keypointNames.empty() && !observers[0]->hasHands())
        options.note(formatText("{} has no {}, so fingers stay as the body has them; {}", options.models.string(), network_files::kHands,
                                howToGetNetworks()));
    const size_t count = scan.frames.size();
    std::vector<Status> results(count);
    std::vector<Whereabouts> where(count);
    std::atomic<size_t> done{0};
    std::atomic<bool> stopped{false};
    Status goesOn;  // of the calling thread, which is worker 0
    const auto tell = [&](uint32_t worker) {
        const size_t frame = ++done;
        if (worker != 0) return;
        goesOn = taskAt(double(frame) / double(2 * count), formatText("frame {} of {}", frame, 2 * count));
        if (!goesOn) stopped = true;
    };
    const auto allGood = [&]() -> Status {
        DPL_RETURN_IF_ERROR(goesOn);
        for (const auto& result : results) DPL_RETURN_IF_ERROR(result);
        return {};
    };
    // First everybody in the pictures without a mask; then, of the chosen one, what is wanted.
    jobs.forBlocks(count, [&](size_t i, uint32_t worker) {
        if (stopped) return;
        results[i] = [&]() -> Status {
            if (!scan.frames[i].maskPath.empty()) return {};
            DPL_TRY(const ImageRgb8 image, readFrameImage(asStored(scan.frames[i])));
            DPL_TRY(where[i].people, observers[worker]->people(image));
            return {};
        }();
        tell(worker);
    });
    DPL_RETURN_IF_ERROR(allGood());
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::StaticCloseup, FrameKind::Dynamic}) {
        std::vector<size_t> order;
        for (size_t f = 0; f < count; ++f)
            if (scan.frames[f].kind == kind && scan.frames[f].maskPath.empty()) order.push_back(f);
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scan.frames[a].timeS < scan.frames[b].timeS; });
        choosePlaces(scan, order, options.persons, where);
    }
    if (const std::string text = describePlaces(scan, where); options.note && !text.empty()) options.note(text);
    const std::string people = placesJson(scan, where);
    DPL_RETURN_IF_ERROR(writeFile(options.output / "people.json", {reinterpret_cast<const uint8_t*>(people.data()), people.size()}));
    for (const PersonPoint& point : options.persons)
        for (size_t f = 0; f < count; ++f)
            if (scan.frames[f].name == point.frame && !isChosenAt(where[f], point.px))
                return fail(Code::InvalidArgument, "--person {}: the networks see nobody there; {} lists the boxes of whom they see",
                            point.frame, (options.output / "people.json").string());
    jobs.forBlocks(count, [&](size_t i, uint32_t worker) {
        if (stopped) return;
        const ScanFrame& frame = scan.frames[i];
        Wanted want = wantedOf(scan, frame);
        want.labels = want.labels && observers[worker]->hasLabels();
        if (want.any())
            results[i] = observeFrame(*observers[worker], frame, want, where[i].start ? &*where[i].start : nullptr, options.output);
        tell(worker);
    });
    return allGood();
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
        if (take(want.mask, made.mask, frame.maskPath)) frame.maskFound = true;
        newLabels |= take(want.labels, made.labels, frame.labelsPath);
    }
    if (scan.keypointNames.empty()) {
        for (const auto name : observedKeypointNames()) scan.keypointNames.emplace_back(name);
        scan.keypointsFound = true;
    }
    if (newLabels && scan.labels.empty())
        scan.labels = {{"background", 0}, {"body", 1}, {"top", 2}, {"bottom", 3}, {"hair", 4}, {"shoes", 5}};
    return scan;
}

}  // namespace dpl
