// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_init.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/subject/body/body_tools.h"

namespace dpl {
namespace {

Mat3d rotationBetween(const Vec3d& from, const Vec3d& to) {
    const Vec3d axis = glm::cross(from, to);
    const double sine = glm::length(axis), cosine = glm::dot(from, to);
    if (sine < 1e-9) return Mat3d(1.0);
    return rotationOf(axis * (std::atan2(sine, cosine) / sine));
}

}  // namespace

Result<FitStart> startFromPoints(const BodyModel& body, const KeypointChain& chain, const std::vector<std::string>& names,
                                 const std::vector<std::optional<Vec3d>>& points, bool metric) {
    FitStart start;
    start.pose.assign(3 * chain.posedCount(), 0.0);
    const std::vector<double> meanShape(chain.shapeCount(), 0.0);
    KeypointChain::Output rest;
    const double still[kRootSize] = {};
    chain.evaluate(Mat3d(1.0), still, start.pose.data(), meanShape.data(), false, rest);

    constexpr std::array<std::string_view, 6> kTorso = {"shoulder_l", "shoulder_r", "hip_l", "hip_r", "neck", "pelvis"};
    std::vector<std::pair<Vec3d, Vec3d>> pairs;
    bool sides[2] = {false, false};
    for (size_t k = 0; k < names.size(); ++k) {
        if (std::find(kTorso.begin(), kTorso.end(), names[k]) == kTorso.end() || !points[k] || !chain.hasKeypoint(k)) continue;
        pairs.emplace_back(rest.points[k], *points[k]);
        if (names[k].ends_with("_l")) sides[0] = true;
        if (names[k].ends_with("_r")) sides[1] = true;
    }
    if (pairs.size() < 4 || !sides[0] || !sides[1])
        return fail(Code::NotFound,
                    "the still frames show {} of the torso's keypoints (shoulders, hips, neck, pelvis) from two sides; at least four are "
                    "needed. Check the keypoint files",
                    pairs.size());
    Eigen::Matrix3Xd from(3, Eigen::Index(pairs.size())), to(3, Eigen::Index(pairs.size()));
    for (size_t i = 0; i < pairs.size(); ++i)
        for (int r = 0; r < 3; ++r) from(r, Eigen::Index(i)) = pairs[i].first[r], to(r, Eigen::Index(i)) = pairs[i].second[r];
    const Eigen::Matrix4d fitted = Eigen::umeyama(from, to, !metric);
    const double scale = metric ? 1.0 : std::cbrt(fitted.topLeftCorner<3, 3>().determinant());
    if (!(scale > 1e-9) || !std::isfinite(scale))
        return fail(Code::CorruptData, "the torso's keypoints collapse to a point; check the cameras");
    start.metresPerUnit = 1 / scale;
    Vec3d shift;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) start.rootReference[c][r] = fitted(r, c) / scale;
    for (int r = 0; r < 3; ++r) shift[r] = fitted(r, 3) / scale;
    // The chain rotates the root about its rest position p, hence R p + t' = p + t.
    const Vec3d p = chain.restPlace(0, meanShape.data());
    const Vec3d translation = start.rootReference * p + shift - p;
    for (int r = 0; r < 3; ++r) start.root[3 + r] = translation[r];

    // Rotate each limb bone towards its triangulated points, parents first.
    struct Bone {
        const char *joint, *from, *to;
    };
    constexpr std::array<Bone, 8> kBones = {{{"leftUpperArm", "shoulder_l", "elbow_l"},
                                             {"leftLowerArm", "elbow_l", "wrist_l"},
                                             {"rightUpperArm", "shoulder_r", "elbow_r"},
                                             {"rightLowerArm", "elbow_r", "wrist_r"},
                                             {"leftUpperLeg", "hip_l", "knee_l"},
                                             {"leftLowerLeg", "knee_l", "ankle_l"},
                                             {"rightUpperLeg", "hip_r", "knee_r"},
                                             {"rightLowerLeg", "knee_r", "ankle_r"}}};
    for (const Bone& bone : kBones) {
        const auto index = [&](const char* name) { return size_t(std::find(names.begin(), names.end(), name) - names.begin()); };
        const size_t a = index(bone.from), b = index(bone.to);
        const int32_t joint = findHumanoid(body, bone.joint);
        const auto slot = std::find(chain.posedJoints().begin(), chain.posedJoints().end(), uint32_t(joint));
        if (a == names.size() || b == names.size() || !points[a] || !points[b] || joint <= 0 || slot == chain.posedJoints().end()) continue;
        KeypointChain::Output now;
        chain.evaluate(start.rootReference, start.root, start.pose.data(), meanShape.data(), false, now);
        const Vec3d is = now.points[b] - now.points[a], should = *points[b] - *points[a];
        if (!(glm::length(is) > 1e-6) || !(glm::length(should) > 1e-6)) continue;
        const Mat3d turn = rotationBetween(glm::normalize(is), glm::normalize(should));  // world
        const Mat3d up = now.rotations[size_t(body.joints[size_t(joint)].parent)];
        const Vec3d w = rotationVector(glm::transpose(up) * turn * now.rotations[size_t(joint)]);
        for (int i = 0; i < 3; ++i) start.pose[3 * size_t(slot - chain.posedJoints().begin()) + size_t(i)] = w[i];
    }
    return start;
}

}  // namespace dpl
