// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/body_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "reconstruction/input/capture/hand_keypoints.h"
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

/** Sums of the fingertips' errors over frames. */
class FingerErrors {
public:
    /** `truth`: hand_keypoints_world of a frame. */
    void add(const ScanFrame& frame, const Camerad& camera, const nlohmann::json& truth, const BodyModel& shaped, const Pose& pose,
             const std::array<std::optional<Vec3d>, 2>& trueWrists) {
        if (!truth.is_array() || truth.size() != 2 * kHandPoints) return;
        std::vector<std::string> names{"wrist_l", "wrist_r"};
        for (const std::string_view name : handKeypointNames()) names.emplace_back(name);
        const std::vector<PosedKeypoint> fitted = posedKeypoints(shaped, pose, names),
                                         rest = posedKeypoints(shaped, Pose::rest(shaped.joints.size()), names);
        if (std::any_of(fitted.begin(), fitted.end(), [](const PosedKeypoint& k) { return !k.present; })) return;
        for (size_t side = 0; side < 2; ++side) {
            if (!trueWrists[side]) continue;
            std::vector<Vec3d> is, atRest, should;
            for (size_t k = 0; k < kHandPoints; ++k) {
                const auto& p = truth[side * kHandPoints + k];
                if (!p.is_array() || p.size() != 3) return;
                should.push_back(upright(p));
                is.push_back(fitted[2 + side * kHandPoints + k].place);
                atRest.push_back(rest[2 + side * kHandPoints + k].place);
            }
            if (lengthPx(camera, *trueWrists[side], should) < kSmallestTrueHandPx) continue;
            const auto tips = tipsSeenByWrist(*trueWrists[side], should), found = tipsSeenByWrist(fitted[side].place, is),
                       never = tipsSeenByWrist(rest[side].place, atRest);
            const bool moving = frame.kind == FrameKind::Dynamic;
            for (size_t f = 0; f < kHandFingers; ++f) {
                mm_[moving].push_back(1000 * glm::length(found[f] - tips[f]));
                atRestMm_[moving].push_back(1000 * glm::length(never[f] - tips[f]));
            }
        }
    }
    FingerTruth spreads() const { return {spreadOf(mm_[0]), spreadOf(mm_[1]), spreadOf(atRestMm_[0]), spreadOf(atRestMm_[1])}; }

private:
    /** The longer side of the hand's box in the picture; 0 where it is not all inside. */
    static double lengthPx(const Camerad& camera, const Vec3d& wrist, std::vector<Vec3d> points) {
        points.push_back(wrist);
        Vec2d low(1e9), high(-1e9);
        for (const Vec3d& p : points) {
            const Vec3d view = camera.toView(p);
            if (!(view.z > 0)) return 0;
            low = glm::min(low, camera.pixelOf(view)), high = glm::max(high, camera.pixelOf(view));
        }
        if (low.x < 0 || low.y < 0 || high.x > camera.widthPx || high.y > camera.heightPx) return 0;
        return std::max(high.x - low.x, high.y - low.y);
    }
    static std::array<Vec3d, kHandFingers> tipsSeenByWrist(const Vec3d& wrist, const std::vector<Vec3d>& points) {
        const Vec3d index = points[kFingerPoints] - wrist, pinky = points[4 * kFingerPoints] - wrist;
        const Vec3d x = glm::normalize(index + pinky), z = glm::normalize(glm::cross(index, pinky)), y = glm::cross(z, x);
        std::array<Vec3d, kHandFingers> tips;
        for (size_t f = 0; f < kHandFingers; ++f)
            tips[f] = glm::transpose(Mat3d(x, y, z)) * (points[f * kFingerPoints + kFingerPoints - 1] - wrist);
        return tips;
    }
    std::vector<double> mm_[2], atRestMm_[2];  // still, moving
};

}  // namespace

Result<TruthComparison> compareWithTruth(const std::filesystem::path& scanRoot, const Scan& scan, const BodyModel& shaped,
                                         const BodyFit& fit) {
    DPL_TRY(const nlohmann::json truth, readTruth(scanRoot / "truth.json"));
    std::map<std::string, const nlohmann::json*> byName, handsByName;
    for (const auto& frame : truth["frames"])
        if (frame.is_object() && frame.contains("name") && frame["name"].is_string() && frame.contains("keypoints_world"))
            byName[frame["name"].get<std::string>()] = &frame["keypoints_world"];
    for (const auto& frame : truth["frames"])
        if (frame.is_object() && frame.contains("name") && frame["name"].is_string() && frame.contains("hand_keypoints_world"))
            handsByName[frame["name"].get<std::string>()] = &frame["hand_keypoints_world"];
    FingerErrors fingers;

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
        const auto wrist = [&](const char* name) {
            const auto pair = pairs.find(name);
            return pair == pairs.end() ? std::nullopt : std::optional(pair->second.second);
        };
        if (const auto hands = handsByName.find(frame.name); hands != handsByName.end())
            fingers.add(frame, metricCamera(frame.camera, fit.metresPerUnit), *hands->second, shaped, fit.poses[f],
                        {wrist("wrist_l"), wrist("wrist_r")});
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
    result.fingers = fingers.spreads();
    for (size_t k = 0; k < perKeypoint.size(); ++k) result.byKeypoint.push_back({scan.keypointNames[k], spreadOf(perKeypoint[k])});
    return result;
}

}  // namespace dpl
