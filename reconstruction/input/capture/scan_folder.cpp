// SPDX-License-Identifier: Apache-2.0
// Reads an avatar-scan folder (docs/formats/scan.md): images, masks, labels, keypoints, cameras, splits. The manifest's skeleton, geometry
// and truth entries are never read, because they are ground truth for measuring.
#include <algorithm>
#include <cmath>
#include <set>

#include "reconstruction/base/image_size.h"
#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/input/capture/person_height.h"
#include "reconstruction/input/capture/scan_readers.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

Result<FrameKind> frameKind(const std::string& text, const std::string& where) {
    if (const auto kind = frameKindNamed(text)) return *kind;
    return fail(Code::CorruptData, "{}: kind '{}' is not one of static_full, static_closeup, dynamic; correct it", where,
                text.substr(0, 60));
}

Result<std::vector<ScanLabel>> readLabels(const json& manifest, const JsonFields& fields) {
    std::vector<ScanLabel> labels;
    if (!fields.has("labels")) return labels;
    const json& table = manifest.at("labels");
    if (!table.is_object() || table.size() > 256)
        return fail(Code::CorruptData, "{}: 'labels' must map names to numbers; correct it", fields.where());
    std::set<int> values;
    for (const auto& [name, value] : table.items()) {
        if (!value.is_number_integer() || value.get<int64_t>() < 0 || value.get<int64_t>() > 255)
            return fail(Code::CorruptData, "{}: label '{}' is not a number from 0 to 255; correct it", fields.where(), name.substr(0, 60));
        const auto number = uint8_t(value.get<int64_t>());
        if (!values.insert(number).second)
            return fail(Code::CorruptData, "{}: two labels have the number {}; correct one", fields.where(), int(number));
        labels.push_back({name, number});
    }
    std::sort(labels.begin(), labels.end(), [](const ScanLabel& a, const ScanLabel& b) { return a.value < b.value; });
    return labels;
}

Result<std::vector<std::string>> readKeypointNames(const JsonFields& fields) {
    std::vector<std::string> names;
    if (!fields.has("keypoint_names")) return names;
    DPL_TRY(const json* list, fields.array("keypoint_names"));
    if (list->size() > 256) return fail(Code::Unsupported, "{}: {} keypoint names, at most 256 are read", fields.where(), list->size());
    std::set<std::string> seen;
    for (const json& name : *list) {
        if (!name.is_string() || !seen.insert(name.get<std::string>()).second)
            return fail(Code::CorruptData, "{}: 'keypoint_names' must be different texts; correct it", fields.where());
        names.push_back(name.get<std::string>());
    }
    return names;
}

/** Values shared by all frames. */
struct Common {
    fs::path root;
    uint32_t widthPx = 0, heightPx = 0;
    LensDistortion lens;
    bool camerasKnown = true;
};

/** "image_size" of the scan or of one frame. */
Status readImageSize(const JsonFields& fields, uint32_t& widthPx, uint32_t& heightPx) {
    DPL_TRY(const auto size, fields.numbers("image_size", 2));
    if (!(size[0] >= 1 && size[1] >= 1 && size[0] <= 65536 && size[1] <= 65536) || size[0] != std::floor(size[0]) ||
        size[1] != std::floor(size[1]))
        return fail(Code::CorruptData, "{}: image_size {} x {} is not a size in pixels; correct it", fields.where(), size[0], size[1]);
    widthPx = uint32_t(size[0]), heightPx = uint32_t(size[1]);
    return checkImageSize(widthPx, heightPx, fields.where());
}

Result<Common> readCommon(const JsonFields& fields, const fs::path& root) {
    Common common{root};
    DPL_RETURN_IF_ERROR(readImageSize(fields, common.widthPx, common.heightPx));
    DPL_TRY(const std::string model, fields.text("camera_model", "pinhole"));
    if (model != "pinhole" && model != "radial")
        return fail(Code::Unsupported, "{}: camera_model '{}' is not read; undistort the images and write 'pinhole'", fields.where(),
                    model.substr(0, 60));
    if (fields.has("distortion")) {
        DPL_TRY(const auto k, fields.numbers("distortion", 2));
        if (model == "pinhole" && (k[0] != 0 || k[1] != 0))
            return fail(Code::CorruptData, "{}: camera_model is 'pinhole' but distortion is not zero; write 'radial' or zeros",
                        fields.where());
        common.lens = {k[0], k[1]};
    }
    return common;
}

/** "focal_px" of a scan without cameras, or 0. */
Result<double> readFocalGuess(const JsonFields& fields, const Common& common) {
    if (common.lens.any())
        return fail(Code::CorruptData, "{}: distortion is stated, but no camera; remove it, it is found with the cameras", fields.where());
    DPL_TRY(const double focal, fields.number("focal_px", 0));
    if (focal == 0) return focal;
    Camerad probe;  // only its intrinsics are checked
    probe.widthPx = common.widthPx, probe.heightPx = common.heightPx;
    probe.fx = probe.fy = focal, probe.cx = common.widthPx / 2.0, probe.cy = common.heightPx / 2.0;
    DPL_RETURN_IF_ERROR(checkCamera(probe, fields.where() + ": focal_px"));
    return focal;
}

Result<ScanFrame> readFrame(const json& entry, const Common& common, const std::string& where, bool& splitStated) {
    if (!entry.is_object()) return fail(Code::CorruptData, "{} is not an object; correct it", where);
    ScanFrame frame;
    JsonFields unnamed(entry, where);
    DPL_TRY(frame.name, unnamed.text("name"));
    const std::string here = formatText("{} ('{}')", where, frame.name.substr(0, 60));
    JsonFields fields(entry, here);
    DPL_TRY(const std::string kind, fields.text("kind"));
    DPL_TRY(frame.kind, frameKind(kind, here));
    if (fields.has("split")) {
        splitStated = true;
        DPL_TRY(const std::string split, fields.text("split"));
        const auto stated = splitNamed(split);
        if (stated != Split::Train && stated != Split::Test)
            return fail(Code::CorruptData, "{}: split '{}' is neither train nor test; correct it", here, split.substr(0, 60));
        frame.split = *stated;
    }
    const auto path = [&](const char* key, bool needed, fs::path& out) -> Status {
        if (!needed && !fields.has(key)) return {};
        DPL_TRY(const std::string relative, fields.text(key));
        DPL_TRY(out, fileInside(common.root, relative, formatText("{}: '{}'", here, key)));
        return {};
    };
    DPL_RETURN_IF_ERROR(path("image", true, frame.imagePath));
    DPL_RETURN_IF_ERROR(path("mask", false, frame.maskPath));
    DPL_RETURN_IF_ERROR(path("labels", false, frame.labelsPath));
    DPL_RETURN_IF_ERROR(path("keypoints", false, frame.keypointsPath));
    DPL_TRY(frame.closeupOf, fields.text("closeup_of", ""));
    DPL_TRY(frame.timeS, fields.number("time", 0));

    frame.camera.widthPx = common.widthPx, frame.camera.heightPx = common.heightPx;
    if (!common.camerasKnown) return frame;
    if (!fields.has("camera") || !entry.at("camera").is_object())
        return fail(
            Code::CorruptData,
            "{}: 'camera' is missing, while other frames have one; register the frame, remove it, or remove all cameras to have them "
            "found",
            here);
    if (fields.has("image_size")) DPL_RETURN_IF_ERROR(readImageSize(fields, frame.camera.widthPx, frame.camera.heightPx));
    JsonFields camera(entry.at("camera"), here + " camera");
    DPL_TRY(frame.camera.fx, camera.number("fx"));
    DPL_TRY(frame.camera.fy, camera.number("fy"));
    DPL_TRY(frame.camera.cx, camera.number("cx"));
    DPL_TRY(frame.camera.cy, camera.number("cy"));
    DPL_TRY(const auto r, camera.numbers("R", 9));
    DPL_TRY(const auto t, camera.numbers("t", 3));
    frame.camera.viewFromWorldRotation =
        Mat3d(r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]);  // the file is row-major, glm column-major
    frame.camera.viewFromWorldTranslation = {t[0], t[1], t[2]};
    turnZUpWorld(frame.camera);
    DPL_RETURN_IF_ERROR(checkCamera(frame.camera, camera.where()));
    frame.lens = common.lens;
    if (camera.has("distortion")) {
        DPL_TRY(const auto k, camera.numbers("distortion", 4));
        frame.lens = {k[0], k[1], k[2], k[3]};
    }
    DPL_RETURN_IF_ERROR(checkDistortion(frame.lens, frame.camera, camera.where()));
    return frame;
}

}  // namespace

Result<Scan> readScanFolder(const fs::path& manifestPath) {
    DPL_TRY(const json manifest, readJsonObject(manifestPath));
    JsonFields fields(manifest, manifestPath.string());
    DPL_TRY(const std::string format, fields.text("format"));
    if (format != "avatar-scan")
        return fail(Code::CorruptData, "{}: format '{}' is not 'avatar-scan'", manifestPath.string(), format.substr(0, 60));
    DPL_TRY(const double version, fields.number("version"));
    if (version != 1)
        return fail(Code::Version, "{}: scan version {}, this build reads version 1; update doppel or convert the scan",
                    manifestPath.string(), version);
    Scan scan;
    scan.source = ScanSource::Folder;
    scan.root = manifestPath.parent_path();
    scan.splitStated = false;
    DPL_TRY(scan.name, fields.text("name", scan.root.filename().string()));
    DPL_TRY(scan.labels, readLabels(manifest, fields));
    DPL_TRY(scan.keypointNames, readKeypointNames(fields));
    const auto ofHand = [](const std::string& name) { return handKeypointNamed(name) >= 0; };
    std::erase_if(scan.keypointNames, ofHand);  // readHandKeypoints() knows their names
    DPL_TRY(const Common common, readCommon(fields, scan.root));
    DPL_TRY(const json* frames, fields.array("frames"));
    if (frames->size() > kMaxFrames)
        return fail(Code::Unsupported, "{}: {} frames, at most {} are read; remove some frames from the scan", manifestPath.string(),
                    frames->size(), kMaxFrames);
    scan.unitStated = !manifest.contains("metric") || !manifest["metric"].is_null();
    if (scan.unitStated) {
        DPL_TRY(scan.metricWorld, fields.boolean("metric", true));
    } else {
        scan.metricWorld = false;
    }
    DPL_TRY(scan.protocol, fields.text("protocol", ""));
    if (!scan.protocol.empty() && scan.protocol != "neuman")
        return fail(Code::Unsupported, "{}: protocol '{}' is not 'neuman'; remove the field", manifestPath.string(),
                    scan.protocol.substr(0, 60));
    DPL_TRY(scan.subjectHeightM, fields.number("subject_height", 0));
    if (scan.subjectHeightM != 0 && !(scan.subjectHeightM >= kShortestPersonM && scan.subjectHeightM <= kTallestPersonM))
        return fail(Code::CorruptData, "{}: subject_height {} is not between {} and {} m; correct it", manifestPath.string(),
                    scan.subjectHeightM, kShortestPersonM, kTallestPersonM);
    Common shared = common;
    shared.camerasKnown = scan.camerasKnown =
        std::any_of(frames->begin(), frames->end(), [](const json& frame) { return frame.is_object() && frame.contains("camera"); });
    if (!scan.camerasKnown) {
        DPL_TRY(scan.focalGuessPx, readFocalGuess(fields, common));
        scan.metricWorld = false, scan.unitStated = true;
    }
    for (size_t i = 0; i < frames->size(); ++i) {
        DPL_TRY(auto frame, readFrame((*frames)[i], shared, formatText("{} frame {}", manifestPath.string(), i), scan.splitStated));
        scan.frames.push_back(std::move(frame));
    }
    // Names of what no frame brings: what is found instead has names of its own.
    const auto none = [&](auto path) {
        return std::none_of(scan.frames.begin(), scan.frames.end(), [&](const ScanFrame& f) { return !(f.*path).empty(); });
    };
    if (none(&ScanFrame::keypointsPath)) scan.keypointNames.clear();
    if (none(&ScanFrame::labelsPath)) scan.labels.clear();
    DPL_RETURN_IF_ERROR(finishScan(scan));
    return scan;
}

}  // namespace dpl
