// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/skeleton.h"

#include <cmath>

namespace dpl {
namespace {

constexpr float kArmDownRad = 0.733f;  // 42°: low enough for shirts to hang naturally, high enough to keep arms clear of the hips

struct JointRow {
    const char* name;
    int parent;
    const char* bone;
};

constexpr JointRow kRows[kBuiltinJointCount] = {
    {"pelvis", -1, "hips"},
    {"left_hip", kPelvis, "leftUpperLeg"},
    {"right_hip", kPelvis, "rightUpperLeg"},
    {"spine1", kPelvis, "spine"},
    {"left_knee", kLeftHip, "leftLowerLeg"},
    {"right_knee", kRightHip, "rightLowerLeg"},
    {"spine2", kSpine1, "chest"},
    {"left_ankle", kLeftKnee, "leftFoot"},
    {"right_ankle", kRightKnee, "rightFoot"},
    {"spine3", kSpine2, "upperChest"},
    {"left_foot", kLeftAnkle, "leftToes"},
    {"right_foot", kRightAnkle, "rightToes"},
    {"neck", kSpine3, "neck"},
    {"left_collar", kSpine3, "leftShoulder"},
    {"right_collar", kSpine3, "rightShoulder"},
    {"head", kNeck, "head"},
    {"left_shoulder", kLeftCollar, "leftUpperArm"},
    {"right_shoulder", kRightCollar, "rightUpperArm"},
    {"left_elbow", kLeftShoulder, "leftLowerArm"},
    {"right_elbow", kRightShoulder, "rightLowerArm"},
    {"left_wrist", kLeftElbow, "leftHand"},
    {"right_wrist", kRightElbow, "rightHand"},
    {"jaw", kHead, "jaw"},
    {"left_eye", kHead, "leftEye"},
    {"right_eye", kHead, "rightEye"},
};

// Joints 1 to 3 and tip in the hand frame (along, thumbward, dorsal), metres. A relaxed hand with fingers slightly spread and bent.
constexpr float kFingerPlaces[kFingerCount][4][3] = {
    {{0.092f, 0.031f, 0.003f}, {0.133f, 0.039f, -0.001f}, {0.157f, 0.0435f, -0.006f}, {0.177f, 0.047f, -0.012f}},         // index
    {{0.096f, 0.008f, 0.005f}, {0.142f, 0.0095f, 0.001f}, {0.170f, 0.0105f, -0.005f}, {0.192f, 0.011f, -0.012f}},         // middle
    {{0.081f, -0.035f, -0.002f}, {0.112f, -0.046f, -0.007f}, {0.130f, -0.0525f, -0.012f}, {0.147f, -0.0585f, -0.018f}},   // pinky
    {{0.090f, -0.0145f, 0.003f}, {0.132f, -0.0210f, -0.002f}, {0.158f, -0.0250f, -0.008f}, {0.179f, -0.0285f, -0.015f}},  // ring
    {{0.020f, 0.022f, -0.008f}, {0.056f, 0.052f, -0.016f}, {0.083f, 0.068f, -0.021f}, {0.107f, 0.080f, -0.025f}},         // thumb
};

}  // namespace

uint8_t mirroredJoint(uint8_t joint) {
    constexpr int fingers = kRightIndex1 - kLeftIndex1;
    if (joint >= kRightIndex1) return uint8_t(joint - fingers);
    if (joint >= kLeftIndex1) return uint8_t(joint + fingers);
    switch (joint) {
        case kPelvis:
        case kSpine1:
        case kSpine2:
        case kSpine3:
        case kNeck:
        case kHead:
        case kJaw:
            return joint;
        default:
            break;
    }
    const char side = kRows[joint].name[0];
    return uint8_t(side == 'l' ? joint + 1 : joint - 1);  // a right joint follows its left one in the list
}

HandFrame leftHandFrame() {
    const float c = std::cos(kArmDownRad), s = std::sin(kArmDownRad);
    const Vec3f shoulder(0.178f, 1.413f, -0.022f);
    const Vec3f elbow = shoulder + 0.282f * glm::normalize(Vec3f(c, -s, -0.03f));
    const Vec3f along = glm::normalize(Vec3f(c, -s, 0.10f));  // points slightly forward: a relaxed elbow is bent
    HandFrame hand;
    hand.wrist = elbow + 0.255f * along;
    hand.along = glm::normalize(Vec3f(std::cos(kArmDownRad + 0.10f), -std::sin(kArmDownRad + 0.10f), 0.10f));
    hand.dorsal = glm::normalize(Vec3f(s, c, 0.12f) - hand.along * glm::dot(Vec3f(s, c, 0.12f), hand.along));
    hand.thumbward = glm::cross(hand.along, hand.dorsal);
    if (hand.thumbward.z < 0) hand.thumbward = -hand.thumbward;
    return hand;
}

std::array<Vec3f, 4> leftFingerChain(Finger finger) {
    const HandFrame hand = leftHandFrame();
    std::array<Vec3f, 4> chain;
    for (int i = 0; i < 4; ++i) chain[i] = hand.at(kFingerPlaces[finger][i][0], kFingerPlaces[finger][i][1], kFingerPlaces[finger][i][2]);
    return chain;
}

std::array<Vec3f, 3> leftFootChain() {
    return {Vec3f(0.146f, 0.082f, -0.030f), Vec3f(0.163f, 0.024f, 0.098f), Vec3f(0.172f, 0.012f, 0.172f)};
}

std::vector<JointData> builtinSkeleton() {
    std::array<Vec3f, kBuiltinJointCount> at;
    at.fill(Vec3f(0));
    at[kPelvis] = {0, 0.945f, -0.012f};
    at[kSpine1] = {0, 1.045f, -0.020f};
    at[kSpine2] = {0, 1.155f, -0.028f};
    at[kSpine3] = {0, 1.255f, -0.030f};
    at[kNeck] = {0, 1.462f, -0.030f};
    at[kHead] = {0, 1.565f, -0.006f};
    at[kJaw] = {0, 1.578f, 0.018f};
    at[kLeftEye] = {0.0315f, 1.6455f, 0.0745f};
    at[kLeftCollar] = {0.045f, 1.405f, -0.012f};
    at[kLeftShoulder] = {0.178f, 1.413f, -0.022f};
    at[kLeftElbow] = at[kLeftShoulder] + 0.282f * glm::normalize(Vec3f(std::cos(kArmDownRad), -std::sin(kArmDownRad), -0.03f));
    at[kLeftWrist] = leftHandFrame().wrist;
    at[kLeftHip] = {0.092f, 0.902f, -0.004f};
    at[kLeftKnee] = {0.121f, 0.495f, 0.008f};
    at[kLeftAnkle] = leftFootChain()[0];
    at[kLeftFoot] = leftFootChain()[1];
    for (int f = 0; f < kFingerCount; ++f) {
        const auto chain = leftFingerChain(Finger(f));
        for (int b = 0; b < 3; ++b) at[leftFingerJoint(Finger(f), b)] = chain[b];
    }
    for (uint8_t j = 0; j < kBuiltinJointCount; ++j) {
        const uint8_t other = mirroredJoint(j);
        if (other > j) at[other] = {-at[j].x, at[j].y, at[j].z};
    }

    std::vector<JointData> joints(kBuiltinJointCount);
    for (int j = 0; j < kLeftIndex1; ++j) joints[j] = {kRows[j].name, kRows[j].parent, at[j], kRows[j].bone};
    constexpr const char* kFingerNames[kFingerCount] = {"index", "middle", "pinky", "ring", "thumb"};
    constexpr const char* kBoneNames[kFingerCount] = {"Index", "Middle", "Little", "Ring", "Thumb"};
    constexpr const char* kPhalanges[3] = {"Proximal", "Intermediate", "Distal"};
    constexpr const char* kThumbParts[3] = {"Metacarpal", "Proximal", "Distal"};
    for (int side = 0; side < 2; ++side)
        for (int f = 0; f < kFingerCount; ++f)
            for (int b = 0; b < 3; ++b) {
                const std::string prefix = side == 0 ? "left" : "right";
                const int j = (side == 0 ? kLeftIndex1 : kRightIndex1) + 3 * f + b;
                const int parent = b == 0 ? (side == 0 ? int(kLeftWrist) : int(kRightWrist)) : j - 1;
                joints[j] = {prefix + "_" + kFingerNames[f] + std::to_string(b + 1), parent, at[j],
                             prefix + kBoneNames[f] + (f == kThumb ? kThumbParts[b] : kPhalanges[b])};
            }
    return joints;
}

}  // namespace dpl
