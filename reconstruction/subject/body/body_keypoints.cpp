// SPDX-License-Identifier: Apache-2.0
// The keypoints of a humanoid body: body points at humanoid bones, face points from the head's vertices, and the hands'.
#include <algorithm>
#include <array>
#include <limits>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/hand_points.h"

namespace dpl {
namespace {

constexpr std::array<std::string_view, 24> kScanKeypoints = {"nose",       "eye_l",      "eye_r",   "ear_l",   "ear_r",   "neck",
                                                             "shoulder_l", "shoulder_r", "elbow_l", "elbow_r", "wrist_l", "wrist_r",
                                                             "knuckle_l",  "knuckle_r",  "pelvis",  "hip_l",   "hip_r",   "knee_l",
                                                             "knee_r",     "ankle_l",    "ankle_r", "toe_l",   "toe_r",   "head_top"};

struct JointKeypoint {
    std::string_view keypoint;
    std::array<std::string_view, 2> bones;  // candidates; the first that the body has is used
};
constexpr std::array<JointKeypoint, 21> kJointKeypoints = {{
    {"eye_l", {"leftEye", ""}},
    {"eye_r", {"rightEye", ""}},
    {"neck", {"neck", "head"}},
    {"shoulder_l", {"leftUpperArm", ""}},
    {"shoulder_r", {"rightUpperArm", ""}},
    {"elbow_l", {"leftLowerArm", ""}},
    {"elbow_r", {"rightLowerArm", ""}},
    {"wrist_l", {"leftHand", ""}},
    {"wrist_r", {"rightHand", ""}},
    {"knuckle_l", {"leftMiddleProximal", "leftIndexProximal"}},
    {"knuckle_r", {"rightMiddleProximal", "rightIndexProximal"}},
    {"pelvis", {"hips", ""}},
    {"hip_l", {"leftUpperLeg", ""}},
    {"hip_r", {"rightUpperLeg", ""}},
    {"knee_l", {"leftLowerLeg", ""}},
    {"knee_r", {"rightLowerLeg", ""}},
    {"ankle_l", {"leftFoot", ""}},
    {"ankle_r", {"rightFoot", ""}},
    {"toe_l", {"leftToes", ""}},
    {"toe_r", {"rightToes", ""}},
    {"head_top", {"", ""}},  // from the head's vertices below
}};

/** Vertices with more than half of their skin weight on the head joint or its descendants. */
std::vector<uint32_t> headVertices(const BodyModel& body, int32_t head) {
    std::vector<bool> below(body.joints.size(), false);
    for (size_t j = 0; j < body.joints.size(); ++j)
        below[j] = int32_t(j) == head || (body.joints[j].parent >= 0 && below[size_t(body.joints[j].parent)]);
    std::vector<uint32_t> vertices;
    for (uint32_t v = 0; v < body.mesh.restPositions.size(); ++v) {
        int weight = 0;
        for (int i = 0; i < 4; ++i)
            if (below[body.mesh.jointIndices[v][i]]) weight += body.mesh.jointWeights[v][i];
        if (weight > 127) vertices.push_back(v);
    }
    return vertices;
}

template <class Score>
uint32_t best(const MeshData& mesh, std::span<const uint32_t> vertices, Score score) {
    uint32_t winner = vertices.front();
    float winning = -std::numeric_limits<float>::infinity();
    for (uint32_t v : vertices)
        if (const float s = score(mesh.restPositions[v]); s > winning) winner = v, winning = s;
    return winner;
}

}  // namespace

std::span<const std::string_view> scanKeypointNames() {
    return kScanKeypoints;
}

std::vector<BodyKeypoint> deriveKeypoints(const BodyModel& body) {
    std::vector<BodyKeypoint> found;
    for (const JointKeypoint& k : kJointKeypoints)
        for (const std::string_view bone : k.bones) {
            const int32_t joint = bone.empty() ? -1 : findHumanoid(body, bone);
            if (joint < 0) continue;
            found.push_back({std::string(k.keypoint), {}, {{uint32_t(joint), 1.0f}}});
            break;
        }

    const int32_t head = findHumanoid(body, "head");
    const std::vector<uint32_t> vertices = head >= 0 ? headVertices(body, head) : std::vector<uint32_t>{};
    if (!vertices.empty()) {
        const auto add = [&](std::string_view name, uint32_t v) { found.push_back({std::string(name), {{v, 1.0f}}, {}}); };
        const float centreX = body.joints[size_t(head)].restPosition.x;
        const uint32_t top = best(body.mesh, vertices, [](const Vec3f& p) { return p.y; });
        const float topY = body.mesh.restPositions[top].y, jointY = body.joints[size_t(head)].restPosition.y;
        // The face lies between the skull's base (a little below the head joint) and the top; the nose is its most forward point.
        const float lowY = jointY - 0.25f * (topY - jointY);
        const uint32_t nose = best(body.mesh, vertices, [&](const Vec3f& p) {
            return p.y < lowY || p.y > topY - 0.25f * (topY - lowY) ? -1e3f : p.z - 0.5f * std::abs(p.x - centreX);
        });
        const float noseY = body.mesh.restPositions[nose].y;
        // Ears: the widest points in a band about eye height, behind the face.
        const auto ear = [&](float side) {
            return best(body.mesh, vertices, [&](const Vec3f& p) {
                return p.y < noseY - 0.02f || p.y > noseY + 0.08f
                           ? -1e3f
                           : side * (p.x - centreX) - 0.2f * std::max(0.0f, p.z - body.joints[size_t(head)].restPosition.z);
            });
        };
        add("nose", nose);
        add("ear_l", ear(1));
        add("ear_r", ear(-1));
        add("head_top", top);
    }
    std::sort(found.begin(), found.end(), [](const BodyKeypoint& a, const BodyKeypoint& b) {
        return std::find(kScanKeypoints.begin(), kScanKeypoints.end(), a.name) <
               std::find(kScanKeypoints.begin(), kScanKeypoints.end(), b.name);
    });
    const std::vector<BodyKeypoint> hands = deriveHandKeypoints(body);
    found.insert(found.end(), hands.begin(), hands.end());
    return found;
}

}  // namespace dpl
