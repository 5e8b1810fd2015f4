// SPDX-License-Identifier: Apache-2.0
// Small rigs for the avatar tests: a person of 1.7 m in A- or T-pose with SMPL-X names.
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "sdk/avatar/humanoid.h"
#include "sdk/format/avatar_data.h"

namespace dpl::test {

/** armsDownRad: 0 is a T-pose, 0.8 an A-pose. Faces +Z, left is +X, ankles 8 cm above the floor. */
inline std::vector<JointData> personRig(float armsDownRad, float legSpreadRad = 0.05f) {
    std::vector<JointData> joints;
    std::map<std::string, int> index;
    const auto add = [&](const std::string& name, const std::string& parent, Vec3f at) {
        index[name] = int(joints.size());
        joints.push_back({name, parent.empty() ? -1 : index.at(parent), at, {}});
    };
    add("pelvis", "", {0, 0.95f, 0});
    add("spine1", "pelvis", {0, 1.05f, -0.01f});
    add("spine2", "spine1", {0, 1.17f, -0.02f});
    add("spine3", "spine2", {0, 1.25f, -0.01f});
    add("neck", "spine3", {0, 1.45f, -0.02f});
    add("head", "neck", {0, 1.55f, 0.02f});
    for (const int sign : {1, -1}) {
        const std::string s = sign > 0 ? "left_" : "right_";
        const auto m = [&](Vec3f p) { return Vec3f(p.x * float(sign), p.y, p.z); };
        const Vec3f leg(std::sin(legSpreadRad), -std::cos(legSpreadRad), 0), arm(std::cos(armsDownRad), -std::sin(armsDownRad), 0);
        const Vec3f across(0, 0, 1);
        const Vec3f hip(0.09f, 0.9f, 0), knee = hip + 0.41f * leg, ankle = knee + 0.41f * leg;
        add(s + "hip", "pelvis", m(hip));
        add(s + "knee", s + "hip", m(knee));
        add(s + "ankle", s + "knee", m(ankle));
        add(s + "foot", s + "ankle", m({ankle.x, 0.02f, 0.13f}));
        const Vec3f shoulder(0.18f, 1.4f, -0.02f), elbow = shoulder + 0.27f * arm + 0.01f * across,
                                                   wrist = elbow + 0.25f * arm + 0.02f * across;
        add(s + "collar", "spine3", m({0.06f, 1.38f, -0.01f}));
        add(s + "shoulder", s + "collar", m(shoulder));
        add(s + "elbow", s + "shoulder", m(elbow));
        add(s + "wrist", s + "elbow", m(wrist));
        float z = 0.03f;
        for (const char* finger : {"index", "middle", "ring", "pinky"}) {
            const Vec3f knuckle = wrist + 0.09f * arm + z * across;
            for (int i = 0; i < 3; ++i)
                add(s + finger + std::to_string(i + 1), i == 0 ? s + "wrist" : s + finger + std::to_string(i),
                    m(knuckle + float(i) * 0.03f * arm));
            z -= 0.02f;
        }
    }
    assignHumanoidBones(joints);
    return joints;
}

inline size_t jointOf(const std::vector<JointData>& joints, const std::string& bone) {
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].humanoidBone == bone) return j;
    return SIZE_MAX;
}

}  // namespace dpl::test
