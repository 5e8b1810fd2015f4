// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/poses_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

ordered_json poseJson(const Pose& pose) {
    ordered_json rotations = ordered_json::array();
    for (const Quatf& q : pose.localRotations) rotations.push_back({q.x, q.y, q.z, q.w});
    return {{"rotations_xyzw", rotations}, {"root_translation", {pose.rootTranslation.x, pose.rootTranslation.y, pose.rootTranslation.z}}};
}

bool readNumbers(const json& list, size_t count, float* out) {
    if (!list.is_array() || list.size() != count) return false;
    for (size_t i = 0; i < count; ++i) {
        if (!list[i].is_number()) return false;
        out[i] = list[i].get<float>();
        if (!std::isfinite(out[i])) return false;
    }
    return true;
}

Result<Pose> readPose(const json& object, size_t jointCount) {
    const auto rotations = object.find("rotations_xyzw"), translation = object.find("root_translation");
    if (rotations == object.end() || !rotations->is_array() || rotations->size() != jointCount)
        return fail(Code::CorruptData, "rotations_xyzw must have {} entries", jointCount);
    Pose pose;
    for (size_t j = 0; j < jointCount; ++j) {
        float q[4];
        if (!readNumbers((*rotations)[j], 4, q)) return fail(Code::CorruptData, "rotation {} is not four finite numbers", j);
        pose.localRotations.push_back(Quatf(q[3], q[0], q[1], q[2]));
    }
    float t[3];
    if (translation == object.end() || !readNumbers(*translation, 3, t))
        return fail(Code::CorruptData, "root_translation is not three finite numbers");
    pose.rootTranslation = {t[0], t[1], t[2]};
    return pose;
}

}  // namespace

std::vector<Pose> PosesFile::poses() const {
    std::vector<Pose> out;
    for (const FramePose& frame : frames) out.push_back(frame.pose);
    return out;
}

std::string posesToJson(const PosesFile& poses) {
    ordered_json out = {{"format", "doppel-poses"}, {"version", 1}};
    if (!poses.scanHash.empty()) out["scan"] = poses.scanHash;
    if (!poses.avatarHash.empty()) out["avatar"] = poses.avatarHash;
    out["joints"] = poses.jointNames;
    for (const Vec3f& p : poses.restPositions) out["rest_positions"].push_back({p.x, p.y, p.z});
    out["frames"] = ordered_json::array();
    if (poses.metresPerUnit > 0) out["metres_per_unit"] = poses.metresPerUnit;
    for (const FramePose& frame : poses.frames) {
        ordered_json entry = {
            {"name", frame.name}, {"kind", frameKindName(frame.kind)}, {"split", splitName(frame.split)}, {"pose", poseJson(frame.pose)}};
        if (frame.fittedPose) entry["fitted_pose"] = poseJson(*frame.fittedPose);
        out["frames"].push_back(std::move(entry));
    }
    return out.dump(1);
}

Result<PosesFile> readPosesFile(const std::filesystem::path& path) {
    DPL_TRY(auto bytes, readFile(path, uint64_t(256) << 20));
    const json root = json::parse(bytes.begin(), bytes.end(), nullptr, false);
    const auto bad = [&](const std::string& what) {
        return fail(Code::CorruptData, "{}: {}; write it again with `doppel reconstruct`", path.string(), what);
    };
    if (!root.is_object() || root.value("format", json()) != json("doppel-poses")) return bad("not a doppel-poses file");
    if (root.value("version", json()) != json(1)) return fail(Code::Version, "{}: poses version is not 1", path.string());
    if (!root.contains("joints") || !root["joints"].is_array() || !root.contains("frames") || !root["frames"].is_array())
        return bad("joints or frames are missing");
    PosesFile out;
    for (const json& name : root["joints"]) {
        if (!name.is_string()) return bad("a joint name is not a string");
        out.jointNames.push_back(name.get<std::string>());
    }
    for (const auto& [key, hash] : {std::pair("scan", &out.scanHash), std::pair("avatar", &out.avatarHash)})
        if (const auto found = root.find(key); found != root.end() && found->is_string()) *hash = found->get<std::string>();
    if (const auto places = root.find("rest_positions"); places != root.end()) {
        if (!places->is_array() || places->size() != out.jointNames.size()) return bad("rest_positions does not have one place a joint");
        for (const json& place : *places) {
            float p[3];
            if (!readNumbers(place, 3, p)) return bad("a rest position is not three finite numbers");
            out.restPositions.push_back({p[0], p[1], p[2]});
        }
    }
    if (const auto scale = root.find("metres_per_unit"); scale != root.end()) {
        if (!scale->is_number() || !(scale->get<double>() > 0) || !std::isfinite(scale->get<double>()))
            return bad("metres_per_unit is not a positive number");
        out.metresPerUnit = scale->get<double>();
    }
    for (const json& entry : root["frames"]) {
        if (!entry.is_object() || !entry.contains("name") || !entry["name"].is_string() || !entry.contains("pose") ||
            !entry["pose"].is_object())
            return bad("a frame has no name or no pose");
        FramePose frame;
        frame.name = entry["name"].get<std::string>();
        const auto text = [&](const char* key) {
            return entry.contains(key) && entry[key].is_string() ? entry[key].get<std::string>() : std::string();
        };
        const auto kind = frameKindNamed(text("kind"));
        const auto split = splitNamed(text("split"));
        if (!kind) return bad("frame " + frame.name + ": kind is not static_full, static_closeup or dynamic");
        if (!split) return bad("frame " + frame.name + ": split is not train, validation or test");
        frame.kind = *kind, frame.split = *split;
        auto pose = readPose(entry["pose"], out.jointNames.size());
        if (!pose) return bad("frame " + frame.name + ": " + pose.error().message);
        frame.pose = std::move(*pose);
        if (entry.contains("fitted_pose") && entry["fitted_pose"].is_object()) {
            auto fitted = readPose(entry["fitted_pose"], out.jointNames.size());
            if (!fitted) return bad("frame " + frame.name + ": " + fitted.error().message);
            frame.fittedPose = std::move(*fitted);
        }
        out.frames.push_back(std::move(frame));
    }
    return out;
}

Status checkSkeleton(const PosesFile& poses, const std::filesystem::path& posesPath, std::span<const JointData> joints,
                     const std::filesystem::path& avatarPath) {
    constexpr float kSamePlaceM = 0.002f;  // files round places, and two people differ by centimetres
    if (poses.jointNames.size() != joints.size())
        return fail(Code::InvalidArgument, "{} poses {} joints, {} has {}; name the poses.json of its reconstruction with --poses",
                    posesPath.string(), poses.jointNames.size(), avatarPath.string(), joints.size());
    for (size_t j = 0; j < poses.restPositions.size(); ++j)
        if (const float apartM = glm::length(poses.restPositions[j] - joints[j].restPosition); !(apartM <= kSamePlaceM))
            return fail(Code::InvalidArgument,
                        "{} is of another person or scan than {}: the joint '{}' rests {} mm away; name the poses.json of its "
                        "reconstruction with --poses",
                        avatarPath.string(), posesPath.string(), joints[j].name, std::lround(1000 * apartM));
    return {};
}

}  // namespace dpl
