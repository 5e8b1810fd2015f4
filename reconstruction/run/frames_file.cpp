// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/frames_file.h"

#include <nlohmann/json.hpp>

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/** The path from `root`, or the absolute one if it does not lie below. */
std::string pathFrom(const fs::path& root, const fs::path& path) {
    std::error_code error;
    const fs::path whole = fs::weakly_canonical(path, error), from = whole.lexically_relative(fs::weakly_canonical(root, error));
    return (from.empty() || *from.begin() == ".." ? whole : from).generic_string();
}

ordered_json cameraJson(const Camerad& camera) {
    ordered_json numbers = {camera.fx, camera.fy, camera.cx, camera.cy};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) numbers.push_back(camera.viewFromWorldRotation[column][row]);
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(camera.viewFromWorldTranslation[axis]);
    return numbers;
}

}  // namespace

std::string framesToJson(const Scan& scan, std::span<const Camerad> cameras, const fs::path& out) {
    ordered_json frames = ordered_json::array();
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        const ScanFrame& frame = scan.frames[f];
        ordered_json entry = {{"name", frame.name},
                              {"image", pathFrom(scan.root, frame.imagePath)},
                              {"mask", frame.maskPath.empty() || frame.maskFound ? "" : pathFrom(scan.root, frame.maskPath)},
                              {"size", {cameras[f].widthPx, cameras[f].heightPx}},
                              {"camera", cameraJson(cameras[f])}};
        if (frame.lens.any()) entry["distortion"] = {frame.lens.k1, frame.lens.k2, frame.lens.p1, frame.lens.p2};
        frames.push_back(std::move(entry));
    }
    const ordered_json file = {
        {"format", "doppel-frames"}, {"version", 1}, {"scan", pathFrom(out, scan.root)}, {"frames", std::move(frames)}};
    return file.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dpl
