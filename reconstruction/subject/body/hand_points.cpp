// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/hand_points.h"

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/body/body_tools.h"

namespace dpl {
namespace {

constexpr float kMinTipM = 0.003f;  // a tip nearer to its joint is no tip

/** The vertex that belongs to `joint` most and lies farthest along `direction` from it; −1: the joint has none. */
int64_t farthest(const BodyModel& body, uint32_t joint, const Vec3f& direction) {
    int64_t winner = -1;
    float winning = kMinTipM;
    for (size_t v = 0; v < body.mesh.restPositions.size(); ++v) {
        int weight = 0;
        for (int i = 0; i < 4; ++i)
            if (body.mesh.jointIndices[v][i] == joint) weight += body.mesh.jointWeights[v][i];
        if (weight <= 127) continue;
        const float along = glm::dot(body.mesh.restPositions[v] - body.joints[joint].restPosition, direction);
        if (along > winning) winning = along, winner = int64_t(v);
    }
    return winner;
}

}  // namespace

std::optional<FingerJoints> fingerJoints(const BodyModel& body, size_t finger) {
    constexpr const char* kNames[kHandFingers] = {"Thumb", "Index", "Middle", "Ring", "Little"};
    constexpr const char* kThumbBones[3] = {"Metacarpal", "Proximal", "Distal"};
    constexpr const char* kFingerBones[3] = {"Proximal", "Intermediate", "Distal"};
    const bool thumb = finger % kHandFingers == 0;
    const std::string stem = std::string(finger < kHandFingers ? "left" : "right") + kNames[finger % kHandFingers];
    FingerJoints joints{};
    for (size_t i = 0; i < joints.size(); ++i) {
        const int32_t joint = findHumanoid(body, stem + (thumb ? kThumbBones : kFingerBones)[i]);
        if (joint < 0 || (i > 0 && body.joints[size_t(joint)].parent != int32_t(joints[i - 1]))) return std::nullopt;
        joints[i] = uint32_t(joint);
    }
    return joints;
}

std::vector<BodyKeypoint> deriveHandKeypoints(const BodyModel& body) {
    std::vector<BodyKeypoint> points;
    for (size_t finger = 0; finger < 2 * kHandFingers; ++finger) {
        const auto joints = fingerJoints(body, finger);
        if (!joints) continue;
        const Vec3f bone = body.joints[(*joints)[2]].restPosition - body.joints[(*joints)[1]].restPosition;
        if (!(glm::length(bone) > 0)) continue;
        const int64_t tip = farthest(body, (*joints)[2], glm::normalize(bone));
        if (tip < 0) continue;
        for (size_t i = 0; i < kFingerPoints; ++i) {
            BodyKeypoint point{std::string(handKeypointNames()[finger * kFingerPoints + i]), {}, {}};
            if (i < joints->size())
                point.joints = {{(*joints)[i], 1.0f}};
            else
                point.vertices = {{uint32_t(tip), 1.0f}};
            points.push_back(std::move(point));
        }
    }
    return points;
}

}  // namespace dpl
