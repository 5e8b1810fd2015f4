// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/body_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "reconstruction/subject/body/body_tools.h"
#include "sdk/core/files.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

/** The 12 limb bones as pairs of keypoints. */
constexpr std::array<std::array<const char*, 2>, 12> kLimbs = {{{"shoulder_l", "elbow_l"},
                                                                {"elbow_l", "wrist_l"},
                                                                {"wrist_l", "knuckle_l"},
                                                                {"shoulder_r", "elbow_r"},
                                                                {"elbow_r", "wrist_r"},
                                                                {"wrist_r", "knuckle_r"},
                                                                {"hip_l", "knee_l"},
                                                                {"knee_l", "ankle_l"},
                                                                {"ankle_l", "toe_l"},
                                                                {"hip_r", "knee_r"},
                                                                {"knee_r", "ankle_r"},
                                                                {"ankle_r", "toe_r"}}};

ErrorSpread spreadOf(std::vector<double> values) {
    ErrorSpread s;
    s.count = values.size();
    if (values.empty()) return s;
    std::sort(values.begin(), values.end());
    for (double v : values) s.mean += v / double(values.size());
    s.median = values[values.size() / 2];
    s.p95 = values[std::min(values.size() - 1, values.size() * 95 / 100)];
    s.max = values.back();
    return s;
}

}  // namespace

std::vector<PosedKeypoint> posedKeypoints(const BodyModel& shaped, const Pose& pose, const std::vector<std::string>& names,
                                          std::span<const LandmarkOffset> landmarks) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(shaped.joints, pose, worldFromRest);
    const auto move = [&](size_t joint, const Vec3f& p) { return Vec3d(worldFromRest[joint] * Vec4f(p, 1)); };
    std::vector<PosedKeypoint> places(names.size());
    for (size_t k = 0; k < names.size(); ++k) {
        for (const BodyKeypoint& keypoint : shaped.keypoints) {
            if (keypoint.name != names[k]) continue;
            places[k].present = true;
            for (auto [joint, weight] : keypoint.joints) places[k].place += double(weight) * move(joint, shaped.joints[joint].restPosition);
            for (auto [vertex, weight] : keypoint.vertices)
                places[k].place += double(weight) * Vec3d(skinVertex(shaped.mesh.restPositions[vertex], shaped.mesh.jointIndices[vertex],
                                                                     shaped.mesh.jointWeights[vertex], worldFromRest.data()));
        }
        if (k < landmarks.size() && places[k].present)
            places[k].place += Vec3d(worldFromRest[landmarks[k].joint] * Vec4f(Vec3f(landmarks[k].offset), 0));
    }
    return places;
}

namespace {

constexpr size_t kMaxTruthBytes = 256u << 20;

Result<nlohmann::json> readTruth(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxTruthBytes));
    nlohmann::json truth = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (!truth.is_object() || !truth.contains("frames") || !truth["frames"].is_array())
        return fail(Code::CorruptData, "{}: no frames", path.string());
    return truth;
}

/** A point of a z-up file, converted to the y-up world. */
Vec3d upright(const nlohmann::json& p) {
    return {p.at(0).get<double>(), p.at(2).get<double>(), -p.at(1).get<double>()};
}

}  // namespace

Result<TruthComparison> compareWithTruth(const std::filesystem::path& scanRoot, const Scan& scan, const BodyModel& shaped,
                                         const BodyFit& fit) {
    DPL_TRY(const nlohmann::json truth, readTruth(scanRoot / "truth.json"));
    std::map<std::string, const nlohmann::json*> byName;
    for (const auto& frame : truth["frames"])
        if (frame.is_object() && frame.contains("name") && frame["name"].is_string() && frame.contains("keypoints_world"))
            byName[frame["name"].get<std::string>()] = &frame["keypoints_world"];

    std::vector<double> test, train, still, limbs;
    std::vector<std::vector<double>> perKeypoint(scan.keypointNames.size());
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        const ScanFrame& frame = scan.frames[f];
        const auto found = byName.find(frame.name);
        if (found == byName.end() || found->second->size() != scan.keypointNames.size()) continue;
        std::map<std::string, std::pair<Vec3d, Vec3d>> pairs;  // name -> (fitted, true)
        const auto fitted = posedKeypoints(shaped, fit.poses[f], scan.keypointNames, fit.landmarks);
        for (size_t k = 0; k < fitted.size(); ++k) {
            const auto& p = (*found->second)[k];
            if (!fitted[k].present || !p.is_array() || p.size() != 3) continue;
            const Vec3d place = upright(p);
            pairs[scan.keypointNames[k]] = {fitted[k].place, place};
            const double mm = 1000 * glm::length(fitted[k].place - place);
            if (frame.kind == FrameKind::StaticFull) still.push_back(mm);
            if (frame.kind != FrameKind::Dynamic) continue;
            if (frame.split == Split::Train) train.push_back(mm);
            if (frame.split != Split::Test) continue;
            test.push_back(mm);
            perKeypoint[k].push_back(mm);
        }
        if (frame.kind != FrameKind::Dynamic || frame.split != Split::Test) continue;
        for (const auto& [from, to] : kLimbs) {
            const auto a = pairs.find(from), b = pairs.find(to);
            if (a == pairs.end() || b == pairs.end()) continue;
            const Vec3d is = glm::normalize(b->second.first - a->second.first),
                        should = glm::normalize(b->second.second - a->second.second);
            limbs.push_back(glm::degrees(std::atan2(glm::length(glm::cross(is, should)), glm::dot(is, should))));
        }
    }
    TruthComparison result;
    if (truth.contains("shape") && truth["shape"].is_object() && truth["shape"].contains("body"))
        result.sameBody = truth["shape"]["body"] == shaped.name;
    result.keypointsMm = spreadOf(test);
    result.trainKeypointsMm = spreadOf(train);
    result.staticKeypointsMm = spreadOf(still);
    result.limbDegrees = spreadOf(limbs);
    for (size_t k = 0; k < perKeypoint.size(); ++k) result.byKeypoint.push_back({scan.keypointNames[k], spreadOf(perKeypoint[k])});
    return result;
}

}  // namespace dpl
