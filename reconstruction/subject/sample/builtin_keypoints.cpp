// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/sample/builtin_parts.h"

namespace dpl {
namespace {

/** The landmark as a weighted mean of the corners of the triangle whose centre is nearest. */
BodyKeypoint onSurface(const char* name, const SurfaceMesh& mesh, const Vec3f& landmark) {
    float best = std::numeric_limits<float>::max();
    Triangle nearest{0, 0, 0};
    for (const Triangle& t : mesh.triangles) {
        const Vec3f d = (mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) / 3.0f - landmark;
        if (glm::dot(d, d) < best) best = glm::dot(d, d), nearest = t;
    }
    // Weights are inverse distances to the corners.
    float weight[3], sum = 0;
    for (int c = 0; c < 3; ++c) {
        weight[c] = 1.0f / (glm::length(mesh.positions[nearest[c]] - landmark) + 1e-4f);
        sum += weight[c];
    }
    BodyKeypoint k{name, {}, {}};
    for (int c = 0; c < 3; ++c) k.vertices.push_back({nearest[c], weight[c] / sum});
    return k;
}

BodyKeypoint atJoint(const char* name, uint8_t joint) {
    return {name, {}, {{joint, 1.0f}}};
}

}  // namespace

std::vector<BodyKeypoint> bodyKeypoints(const SurfaceMesh& mesh) {
    return {
        onSurface("nose", mesh, {0, 1.612f, 0.121f}),
        onSurface("eye_l", mesh, {0.0315f, 1.6455f, 0.087f}),
        onSurface("eye_r", mesh, {-0.0315f, 1.6455f, 0.087f}),
        onSurface("ear_l", mesh, {0.084f, 1.628f, -0.010f}),
        onSurface("ear_r", mesh, {-0.084f, 1.628f, -0.010f}),
        atJoint("neck", kNeck),
        atJoint("shoulder_l", kLeftShoulder),
        atJoint("shoulder_r", kRightShoulder),
        atJoint("elbow_l", kLeftElbow),
        atJoint("elbow_r", kRightElbow),
        atJoint("wrist_l", kLeftWrist),
        atJoint("wrist_r", kRightWrist),
        atJoint("knuckle_l", kLeftMiddle1),
        atJoint("knuckle_r", uint8_t(kLeftMiddle1 + (kRightIndex1 - kLeftIndex1))),
        atJoint("pelvis", kPelvis),
        atJoint("hip_l", kLeftHip),
        atJoint("hip_r", kRightHip),
        atJoint("knee_l", kLeftKnee),
        atJoint("knee_r", kRightKnee),
        atJoint("ankle_l", kLeftAnkle),
        atJoint("ankle_r", kRightAnkle),
        atJoint("toe_l", kLeftFoot),
        atJoint("toe_r", kRightFoot),
        onSurface("head_top", mesh, {0, 1.752f, -0.012f}),
    };
}

std::vector<BodyKeypoint> fingerKeypoints(const SurfaceMesh& mesh) {
    constexpr Finger kOrder[kHandFingers] = {kThumb, kIndex, kMiddle, kRing, kPinky};
    std::vector<BodyKeypoint> points;
    for (const bool left : {true, false})
        for (const Finger finger : kOrder)
            for (int i = 0; i < int(kFingerPoints); ++i) {
                const std::string name(handKeypointNames()[points.size()]);
                const uint8_t joint = uint8_t(leftFingerJoint(finger, std::min(i, 2)) + (left ? 0 : kRightIndex1 - kLeftIndex1));
                const Vec3f tip = leftFingerChain(finger)[3];
                points.push_back(i < 3 ? atJoint(name.c_str(), joint)
                                       : onSurface(name.c_str(), mesh, left ? tip : Vec3f(-tip.x, tip.y, tip.z)));
            }
    return points;
}

}  // namespace dpl
