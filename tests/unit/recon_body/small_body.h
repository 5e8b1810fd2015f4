// SPDX-License-Identifier: Apache-2.0
// A small humanoid body for tests: one tetrahedron per joint, with the joints that the fit moves.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/subject/body/body_tools.h"
#include "sdk/avatar/humanoid.h"

namespace dpl {

inline BodyModel smallBody() {
    BodyModel body;
    body.name = "small";
    const auto joint = [&](const char* name, const char* parent, Vec3f p) {
        body.joints.push_back({name, findJoint(body.joints, parent), p, ""});
    };
    joint("pelvis", "", {0, 0.95f, 0});
    joint("spine1", "pelvis", {0, 1.05f, 0});
    joint("spine2", "spine1", {0, 1.18f, 0});
    joint("spine3", "spine2", {0, 1.25f, 0});
    joint("neck", "spine3", {0, 1.5f, 0});
    joint("head", "neck", {0, 1.6f, 0.02f});
    for (const bool left : {true, false}) {
        const float s = left ? 1.0f : -1.0f;
        const std::string side = left ? "left_" : "right_";
        const auto add = [&](const char* name, const char* parent, Vec3f p) {
            const bool central = std::string(parent) == "pelvis" || std::string(parent) == "spine3";
            joint((side + name).c_str(), (central ? parent : side + parent).c_str(), {s * p.x, p.y, p.z});
        };
        add("collar", "spine3", {0.04f, 1.42f, 0});
        add("shoulder", "collar", {0.18f, 1.42f, 0});
        add("elbow", "shoulder", {0.36f, 1.22f, 0});
        add("wrist", "elbow", {0.52f, 1.05f, 0.06f});
        add("middle1", "wrist", {0.58f, 0.97f, 0.09f});
        add("hip", "pelvis", {0.1f, 0.92f, 0});
        add("knee", "hip", {0.12f, 0.5f, 0.01f});
        add("ankle", "knee", {0.13f, 0.08f, -0.02f});
        add("foot", "ankle", {0.14f, 0.03f, 0.1f});
    }
    assignHumanoidBones(body.joints);
    for (uint32_t j = 0; j < body.joints.size(); ++j) {  // one tetrahedron per joint, a larger one for the head
        const float r = body.joints[j].name == "head" ? 0.1f : 0.03f;
        const uint32_t first = uint32_t(body.mesh.restPositions.size());
        for (const Vec3f& d : {Vec3f(r, 0, 0), Vec3f(-r, 0, 0), Vec3f(0, 1.6f * r, 0), Vec3f(0, 0.2f * r, r)}) {
            body.mesh.restPositions.push_back(body.joints[j].restPosition + d);
            body.mesh.colours.push_back({200, 100, 50, 255});
            body.mesh.jointIndices.push_back({j, 0, 0, 0});
            body.mesh.jointWeights.push_back({255, 0, 0, 0});
        }
        for (const Triangle& t : {Triangle(0, 2, 3), Triangle(2, 1, 3), Triangle(1, 0, 3), Triangle(0, 1, 2)})
            body.mesh.triangles.push_back(t + first);
    }
    const uint32_t vertexCount = uint32_t(body.mesh.restPositions.size());
    body.mesh.layers = {{"body", "body", 0, vertexCount, 0, uint32_t(body.mesh.triangles.size())}};
    // "height" stretches everything upward, "width" everything sideways.
    ShapeMorph height{"height", -3, 3, {}, {}}, width{"width", -3, 3, {}, {}};
    for (const Vec3f& p : body.mesh.restPositions)
        height.vertexOffsets.push_back({0, 0.04f * p.y, 0}), width.vertexOffsets.push_back({0.06f * p.x, 0, 0});
    for (const JointData& j : body.joints)
        height.jointOffsets.push_back({0, 0.04f * j.restPosition.y, 0}), width.jointOffsets.push_back({0.06f * j.restPosition.x, 0, 0});
    body.morphs = {height, width};
    body.keypoints = deriveKeypoints(body);
    return body;
}

}  // namespace dpl
