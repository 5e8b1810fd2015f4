// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scan_inputs.h"

#include <map>

#include "reconstruction/run/stage.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json cameraJson(const Camerad& camera) {
    json out = {camera.widthPx, camera.heightPx, camera.fx, camera.fy, camera.cx, camera.cy};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) out.push_back(camera.viewFromWorldRotation[column][row]);
    for (int row = 0; row < 3; ++row) out.push_back(camera.viewFromWorldTranslation[row]);
    return out;
}

/** The hash of a file, or the text of the error if it cannot be read. So the key changes when the file is repaired, and ingest runs again.
 */
std::string hashOrError(const fs::path& path) {
    if (path.empty()) return "none";
    auto hash = hashFile(path);
    return hash ? *hash : hash.error().message;
}

}  // namespace

std::vector<FrameHashes> hashFrames(const Scan& scan) {
    return hashFrames(scan, {}, {});
}

std::vector<FrameHashes> hashFrames(const Scan& scan, const Scan& before, const std::vector<FrameHashes>& known) {
    std::map<std::string_view, size_t> rows;
    for (size_t row = 0; row < before.frames.size(); ++row) rows.emplace(before.frames[row].name, row);
    constexpr std::pair<fs::path ScanFrame::*, std::string FrameHashes::*> kFiles[] = {
        {&ScanFrame::imagePath, &FrameHashes::image},
        {&ScanFrame::maskPath, &FrameHashes::mask},
        {&ScanFrame::labelsPath, &FrameHashes::labels},
        {&ScanFrame::keypointsPath, &FrameHashes::keypoints}};
    std::vector<FrameHashes> hashes;
    for (const ScanFrame& frame : scan.frames) {
        const auto row = rows.find(frame.name);
        FrameHashes& out = hashes.emplace_back();
        for (const auto& [path, hash] : kFiles)
            out.*hash =
                row != rows.end() && before.frames[row->second].*path == frame.*path ? known[row->second].*hash : hashOrError(frame.*path);
    }
    return hashes;
}

std::string hashOfScan(const Scan& scan, const std::vector<FrameHashes>& hashes) {
    json pictures = json::array();
    for (size_t f = 0; f < scan.frames.size(); ++f) pictures.push_back({scan.frames[f].name, hashes[f].image});
    return hashText(pictures.dump());
}

json frameInputs(const ScanFrame& frame, const FrameHashes& files) {
    json inputs = {{"name", frame.name},
                   {"kind", int(frame.kind)},
                   {"split", int(frame.split)},
                   {"time", frame.timeS},
                   {"camera", cameraJson(frame.camera)},
                   {"lens", {frame.lens.k1, frame.lens.k2, frame.lens.p1, frame.lens.p2}},
                   {"files", {files.image, files.mask, files.labels, files.keypoints}}};
    if (frame.maskFound) inputs["mask_found"] = true;
    return inputs;
}

json commonInputs(const Scan& scan) {
    json labels = json::array();
    for (const ScanLabel& label : scan.labels) labels.push_back({label.name, label.value});
    const json metric = scan.unitStated ? json(scan.metricWorld) : json();
    return {{"metric", metric}, {"keypoint_names", scan.keypointNames}, {"labels", labels}};
}

json posedInputs(const Scan& scan, const std::vector<FrameHashes>& hashes) {
    json frames = json::array();
    for (size_t f = 0; f < scan.frames.size(); ++f) frames.push_back(frameInputs(scan.frames[f], {"", "", "", hashes[f].keypoints}));
    return frames;
}

json scanInputs(const Scan& scan, const std::vector<FrameHashes>& hashes) {
    json frames = json::array();
    for (size_t f = 0; f < scan.frames.size(); ++f) frames.push_back(frameInputs(scan.frames[f], hashes[f]));
    return {{"common", commonInputs(scan)}, {"frames", frames}};
}

}  // namespace dpl
