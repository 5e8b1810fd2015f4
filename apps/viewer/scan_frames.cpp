// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scan_frames.h"

#include <cmath>
#include <map>

#include "reconstruction/base/image_size.h"
#include "reconstruction/base/json_fields.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMostBytes = uint64_t(256) << 20;  // as readers of poses.json
constexpr size_t kMostFrames = 100000, kMostJoints = 4096;
constexpr double kMostPx = 65536, kMostM = 1e6;

Result<json> readFormat(const fs::path& path, const char* format) {
    DPL_TRY(const auto bytes, readFile(path, kMostBytes));
    DPL_TRY(json file, parseJsonObject({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string()));
    const JsonFields fields(file, path.string());
    DPL_TRY(const std::string name, fields.text("format"));
    if (name != format) return fail(Code::CorruptData, "{}: not of the format {}", path.string(), format);
    DPL_TRY(const double version, fields.number("version"));
    if (version != 1) return fail(Code::Version, "{}: version {}, and this viewer reads version 1; update it", path.string(), version);
    return file;
}

/** The entries of an array that are objects; another entry is an error. */
Result<const json*> frameList(const json& file, const std::string& where) {
    DPL_TRY(const json* frames, JsonFields(file, where).array("frames"));
    if (frames->size() > kMostFrames) return fail(Code::CorruptData, "{}: {} frames are too many", where, frames->size());
    for (const json& frame : *frames)
        if (!frame.is_object()) return fail(Code::CorruptData, "{}: a frame is damaged; run doppel reconstruct again", where);
    return frames;
}

Result<Camerad> readCamera(const JsonFields& fields) {
    DPL_TRY(const auto size, fields.numbers("size", 2));
    DPL_TRY(const auto n, fields.numbers("camera", 16));
    Camerad camera;
    const auto bounded = [](double value, double least, double most) { return value >= least && value <= most; };
    bool good = bounded(size[0], 1, kMostPx) && bounded(size[1], 1, kMostPx) && bounded(n[0], 1, 1e7) && bounded(n[1], 1, 1e7);
    for (size_t i = 2; i < 16; ++i) good = good && std::abs(n[i]) <= (i < 4 ? kMostPx : i < 13 ? 1.001 : kMostM);
    good = good && size[0] * size[1] <= double(kMaxImagePixels);
    if (!good) return fail(Code::CorruptData, "{}: the camera is out of range; run doppel reconstruct again", fields.where());
    camera.widthPx = uint32_t(size[0]), camera.heightPx = uint32_t(size[1]);
    camera.fx = n[0], camera.fy = n[1], camera.cx = n[2], camera.cy = n[3];
    camera.viewFromWorldRotation = Mat3d(n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11], n[12]);
    camera.viewFromWorldTranslation = {n[13], n[14], n[15]};
    const Mat3d& r = camera.viewFromWorldRotation;
    const Mat3d off = glm::transpose(r) * r - Mat3d(1);
    for (int column = 0; column < 3; ++column)
        if (glm::length(off[column]) > 1e-3) return fail(Code::CorruptData, "{}: the camera is no rotation", fields.where());
    return camera;
}

Status readPose(const json& frame, size_t joints, const std::string& where, ComparedFrame& out) {
    const char* key = frame.contains("fitted_pose") && !frame["fitted_pose"].is_null() ? "fitted_pose" : "pose";
    if (!frame.contains(key) || !frame[key].is_object()) return fail(Code::CorruptData, "{}: a pose is missing", where);
    const JsonFields pose(frame[key], where);
    DPL_TRY(const json* rotations, pose.array("rotations_xyzw"));
    if (rotations->size() != joints)
        return fail(Code::CorruptData, "{}: a pose has {} rotations for {} joints", where, rotations->size(), joints);
    for (const json& q : *rotations) {
        if (!q.is_array() || q.size() != 4) return fail(Code::CorruptData, "{}: a rotation is not four numbers", where);
        for (const json& value : q) {
            if (!value.is_number() || !(std::abs(value.get<double>()) <= 1.001))
                return fail(Code::CorruptData, "{}: a rotation is not four numbers", where);
            out.rotations.push_back(value.get<float>());
        }
    }
    DPL_TRY(const auto root, pose.numbers("root_translation", 3));
    for (size_t i = 0; i < 3; ++i) {
        if (std::abs(root[i]) > kMostM) return fail(Code::CorruptData, "{}: a pose is out of range", where);
        out.root[i] = float(root[i]);
    }
    return {};
}

}  // namespace

bool hasScanFrames(const fs::path& run) {
    std::error_code error;
    return fs::is_regular_file(run / "frames.json", error) && fs::is_regular_file(run / "poses.json", error);
}

Result<ScanFrames> readScanFrames(const fs::path& run) {
    const std::string framesWhere = (run / "frames.json").string(), posesWhere = (run / "poses.json").string();
    DPL_TRY(const json file, readFormat(framesWhere, "doppel-frames"));
    DPL_TRY(const json poses, readFormat(posesWhere, "doppel-poses"));
    ScanFrames out;
    DPL_TRY(const std::string scan, JsonFields(file, framesWhere).text("scan"));
    if (scan.empty() || scan.find('\0') != std::string::npos) return fail(Code::CorruptData, "{}: 'scan' is no folder", framesWhere);
    out.scan = run / scan;  // an absolute path replaces the run's
    DPL_TRY(const json* joints, JsonFields(poses, posesWhere).array("joints"));
    if (joints->size() > kMostJoints) return fail(Code::CorruptData, "{}: {} joints are too many", posesWhere, joints->size());
    for (const json& joint : *joints) {
        if (!joint.is_string()) return fail(Code::CorruptData, "{}: the name of a joint is damaged", posesWhere);
        out.joints.push_back(joint.get<std::string>());
    }
    DPL_TRY(const json* posed, frameList(poses, posesWhere));
    std::map<std::string, const json*> poseOf;
    for (const json& frame : *posed) {
        DPL_TRY(const std::string name, JsonFields(frame, posesWhere).text("name"));
        poseOf[name] = &frame;
    }
    DPL_TRY(const json* frames, frameList(file, framesWhere));
    for (const json& entry : *frames) {
        const JsonFields fields(entry, framesWhere);
        ComparedFrame frame;
        DPL_TRY(frame.name, fields.text("name"));
        const auto pose = poseOf.find(frame.name);
        if (pose == poseOf.end()) continue;
        DPL_TRY(frame.split, JsonFields(*pose->second, posesWhere).text("split", ""));
        DPL_TRY(frame.image, fields.text("image"));
        DPL_TRY(frame.mask, fields.text("mask", ""));
        DPL_TRY(frame.camera, readCamera(fields));
        if (fields.has("distortion")) {
            DPL_TRY(const auto lens, fields.numbers("distortion", 4));
            for (const double k : lens)
                if (std::abs(k) > 10) return fail(Code::CorruptData, "{}: a lens is out of range", framesWhere);
            frame.k1 = lens[0], frame.k2 = lens[1], frame.p1 = lens[2], frame.p2 = lens[3];
        }
        DPL_RETURN_IF_ERROR(readPose(*pose->second, out.joints.size(), posesWhere, frame));
        out.frames.push_back(std::move(frame));
    }
    if (out.frames.empty()) return fail(Code::CorruptData, "{} and poses.json beside it have no frame in common", framesWhere);
    return out;
}

}  // namespace dpl
