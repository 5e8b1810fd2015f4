// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/fit_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

json poseJson(const Pose& pose) {
    json numbers = json::array({pose.rootTranslation.x, pose.rootTranslation.y, pose.rootTranslation.z});
    for (const Quatf& q : pose.localRotations)
        for (float value : {q.x, q.y, q.z, q.w}) numbers.push_back(value);
    return numbers;
}

bool poseFrom(const json& numbers, size_t jointCount, Pose& pose) {
    if (!numbers.is_array() || numbers.size() != 3 + 4 * jointCount) return false;
    for (const json& number : numbers)
        if (!number.is_number() || !std::isfinite(number.get<double>())) return false;
    pose.rootTranslation = {numbers[0].get<float>(), numbers[1].get<float>(), numbers[2].get<float>()};
    pose.localRotations.resize(jointCount);
    for (size_t j = 0; j < jointCount; ++j) {
        const auto at = [&](size_t k) { return numbers[3 + 4 * j + k].get<float>(); };
        pose.localRotations[j] = Quatf(at(3), at(0), at(1), at(2));
    }
    return true;
}

}  // namespace

std::string fitToJson(const BodyFit& fit) {
    json out = {{"shape", fit.shape},
                {"metres_per_unit", fit.metresPerUnit},
                {"keypoint_sigma", fit.keypointSigma},
                {"outlier_share", fit.outlierShare},
                {"landmarks", json::array()},
                {"static_pose", poseJson(fit.staticPose)},
                {"poses", json::array()},
                {"swapped", fit.swapped},
                {"fitted", fit.fitted}};
    for (const LandmarkOffset& l : fit.landmarks) out["landmarks"].push_back({l.joint, l.offset.x, l.offset.y, l.offset.z});
    for (const Pose& pose : fit.poses) out["poses"].push_back(poseJson(pose));
    for (const SolveEnd& s : fit.solves)
        out["solves"].push_back({{"what", s.what},
                                 {"how", s.how},
                                 {"usable", s.usable},
                                 {"steps", s.steps},
                                 {"cost_before", s.costBefore},
                                 {"cost_after", s.costAfter}});
    for (const KindResidual& r : fit.residuals)
        out["residuals"].push_back({{"kind", int(r.kind)},
                                    {"split", int(r.split)},
                                    {"frames", r.frames},
                                    {"keypoints", r.keypoints},
                                    {"mean_px", r.meanPx},
                                    {"median_px", r.medianPx},
                                    {"p95_px", r.p95Px}});
    return out.dump();
}

Result<BodyFit> readFitFile(const std::filesystem::path& path, size_t frameCount, size_t jointCount, size_t morphCount) {
    DPL_TRY(auto bytes, readFile(path, uint64_t(256) << 20));
    const json root = json::parse(bytes.begin(), bytes.end(), nullptr, false);
    const auto bad = [&] { return fail(Code::CorruptData, "{} is damaged; delete it and run again", path.string()); };
    BodyFit fit;
    try {
        fit.shape = root.at("shape").get<std::vector<double>>();
        fit.metresPerUnit = root.at("metres_per_unit").get<double>();
        fit.keypointSigma = root.at("keypoint_sigma").get<double>();
        fit.outlierShare = root.at("outlier_share").get<double>();
        fit.fitted = root.at("fitted").get<std::vector<bool>>();
        fit.swapped = root.at("swapped").get<std::vector<uint8_t>>();
        if (!fit.swapped.empty() && fit.swapped.size() != frameCount) return bad();
        if (fit.shape.size() != morphCount || fit.fitted.size() != frameCount || root.at("poses").size() != frameCount) return bad();
        if (!poseFrom(root.at("static_pose"), jointCount, fit.staticPose)) return bad();
        fit.poses.resize(frameCount);
        for (size_t f = 0; f < frameCount; ++f)
            if (!poseFrom(root.at("poses")[f], jointCount, fit.poses[f])) return bad();
        for (const json& l : root.at("landmarks")) {
            const LandmarkOffset landmark{l.at(0), Vec3d(l.at(1), l.at(2), l.at(3))};
            if (landmark.joint >= jointCount || !std::isfinite(glm::length(landmark.offset))) return bad();
            fit.landmarks.push_back(landmark);
        }
        for (const json& r : root.value("residuals", json::array())) {
            KindResidual residual;
            residual.kind = FrameKind(r.at("kind").get<int>());
            residual.split = Split(r.at("split").get<int>());
            residual.frames = r.at("frames"), residual.keypoints = r.at("keypoints");
            residual.meanPx = r.at("mean_px"), residual.medianPx = r.at("median_px"), residual.p95Px = r.at("p95_px");
            fit.residuals.push_back(residual);
        }
    } catch (const json::exception&) {
        return bad();
    }
    return fit;
}

std::string handsToJson(std::span<const HandFit> hands) {
    json out = json::array();
    for (const HandFit& hand : hands)
        out.push_back({{"left", hand.left},
                       {"turned", hand.turned},
                       {"still_frames", hand.stillFrames},
                       {"moving_frames", hand.movingFrames},
                       {"posed_frames", hand.posedFrames},
                       {"median_px", hand.medianPx}});
    return out.dump();
}

Result<std::vector<HandFit>> readHandsFile(const std::filesystem::path& path) {
    constexpr uint64_t kMostBytes = 1 << 16;
    DPL_TRY(auto bytes, readFile(path, kMostBytes));
    const json root = json::parse(bytes.begin(), bytes.end(), nullptr, false);
    std::vector<HandFit> hands;
    try {
        for (const json& h : root) {
            HandFit hand;
            hand.left = h.at("left"), hand.turned = h.at("turned");
            hand.stillFrames = h.at("still_frames"), hand.movingFrames = h.at("moving_frames"), hand.posedFrames = h.at("posed_frames");
            hand.medianPx = h.at("median_px");
            hands.push_back(hand);
        }
    } catch (const json::exception&) {
        hands.clear();
    }
    if (hands.empty()) return fail(Code::CorruptData, "{} is damaged; delete it and run again", path.string());
    return hands;
}

}  // namespace dpl
