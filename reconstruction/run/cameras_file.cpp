// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/cameras_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

constexpr size_t kCameraNumbers = 16;  // fx fy cx cy, R column by column, t

json cameraNumbers(const Camerad& camera) {
    json out = {camera.fx, camera.fy, camera.cx, camera.cy};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) out.push_back(camera.viewFromWorldRotation[column][row]);
    for (int row = 0; row < 3; ++row) out.push_back(camera.viewFromWorldTranslation[row]);
    return out;
}

bool allFinite(const json& numbers, size_t count) {
    if (!numbers.is_array() || numbers.size() != count) return false;
    return std::all_of(numbers.begin(), numbers.end(), [](const json& n) { return n.is_number() && std::isfinite(n.get<double>()); });
}

bool isText(const json& value) {
    return value.is_string();
}

bool readGap(const json& entry, CameraGap& out) {
    if (!entry.is_object() || !isText(entry.value("part", json())) || !isText(entry.value("sentence", json()))) return false;
    const json frames = entry.value("frames", json());
    if (!frames.is_array() || !std::all_of(frames.begin(), frames.end(), isText)) return false;
    out = {entry["part"], entry["sentence"], frames};
    return true;
}

bool readCamera(const json& entry, FoundCamera& out) {
    if (!entry.is_object() || !entry.value("name", json()).is_string() || !allFinite(entry.value("camera", json()), kCameraNumbers) ||
        !allFinite(entry.value("size", json()), 2))
        return false;
    out.name = entry["name"];
    Camerad& camera = out.camera;
    const double width = entry["size"][0], height = entry["size"][1];
    if (!(width >= 1 && width <= 65536 && height >= 1 && height <= 65536)) return false;
    camera.widthPx = uint32_t(width), camera.heightPx = uint32_t(height);
    const auto at = [&](size_t i) { return entry["camera"][i].get<double>(); };
    camera.fx = at(0), camera.fy = at(1), camera.cx = at(2), camera.cy = at(3);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) camera.viewFromWorldRotation[column][row] = at(4 + size_t(3 * column + row));
    camera.viewFromWorldTranslation = {at(13), at(14), at(15)};
    out.missPx = entry.value("miss_px", 0.0);
    out.matches = entry.value("matches", size_t(0));
    return true;
}

}  // namespace

std::string camerasToJson(const FoundCameras& found) {
    json out = {{"lens", {found.lens.k1, found.lens.k2}}, {"metric", found.metric}, {"refused", found.refused},
                {"sentences", found.sentences},           {"gaps", json::array()},  {"frames", json::array()}};
    for (const CameraGap& gap : found.gaps) out["gaps"].push_back({{"part", gap.part}, {"sentence", gap.sentence}, {"frames", gap.frames}});
    for (const FoundCamera& frame : found.cameras)
        out["frames"].push_back({{"name", frame.name},
                                 {"size", {frame.camera.widthPx, frame.camera.heightPx}},
                                 {"camera", cameraNumbers(frame.camera)},
                                 {"matches", frame.matches},
                                 {"miss_px", frame.missPx}});
    return out.dump(1);
}

FoundCameras camerasOf(const Scan& scan) {
    FoundCameras found;
    found.metric = scan.metricWorld;
    if (!scan.frames.empty()) found.lens = scan.frames[0].lens;
    for (const ScanFrame& frame : scan.frames) found.cameras.push_back({frame.name, frame.camera});
    return found;
}

Result<FoundCameras> readCamerasFile(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path, 64 << 20));
    const json file = json::parse(bytes.begin(), bytes.end(), nullptr, false);
    const Error damaged = fail(Code::CorruptData, "{} is damaged; delete it and run again", path.string());
    if (!file.is_object() || !allFinite(file.value("lens", json()), 2) || !file.value("frames", json()).is_array() ||
        !file.value("sentences", json()).is_array() || !file.value("gaps", json()).is_array() ||
        !file.value("metric", json()).is_boolean() || !file.value("refused", json()).is_boolean())
        return damaged;
    FoundCameras found;
    found.lens = {file["lens"][0], file["lens"][1]};
    found.metric = file["metric"], found.refused = file["refused"];
    for (const json& sentence : file["sentences"]) {
        if (!sentence.is_string()) return damaged;
        found.sentences.push_back(sentence);
    }
    for (const json& entry : file["gaps"])
        if (!readGap(entry, found.gaps.emplace_back())) return damaged;
    for (const json& entry : file["frames"]) {
        FoundCamera frame;
        if (!readCamera(entry, frame)) return damaged;
        const std::string where = formatText("{} frame '{}'", path.string(), frame.name.substr(0, 60));
        DPL_RETURN_IF_ERROR(checkCamera(frame.camera, where));
        DPL_RETURN_IF_ERROR(checkDistortion(found.lens, frame.camera, where));
        found.cameras.push_back(std::move(frame));
    }
    return found;
}

Result<Scan> withCameras(Scan scan, const FoundCameras& found) {
    std::map<std::string, const FoundCamera*> byName;
    for (const FoundCamera& frame : found.cameras) byName[frame.name] = &frame;
    std::vector<ScanFrame> kept;
    for (ScanFrame& frame : scan.frames) {
        const auto at = byName.find(frame.name);
        if (at == byName.end()) continue;
        const Camerad& camera = at->second->camera;
        if (camera.widthPx != frame.camera.widthPx || camera.heightPx != frame.camera.heightPx)
            return fail(Code::CorruptData, "the camera of frame '{}' is for {} x {} pixels, the picture has {} x {}; run again", frame.name,
                        camera.widthPx, camera.heightPx, frame.camera.widthPx, frame.camera.heightPx);
        frame.camera = camera;
        frame.lens = found.lens;
        kept.push_back(std::move(frame));
    }
    scan.frames = std::move(kept);
    scan.camerasKnown = true;
    scan.metricWorld = found.metric;
    return scan;
}

}  // namespace dpl
