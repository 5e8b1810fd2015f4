// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/skinning.h"

#include <cmath>

namespace dpl {
namespace {

Mat3d rotationOf(const Vec3d& axisAngle) {
    const double angle = glm::length(axisAngle);
    if (angle < 1e-12) return Mat3d(1);
    const Vec3d a = axisAngle / angle;
    const double c = std::cos(angle), s = std::sin(angle), k = 1 - c;
    return Mat3d(c + a.x * a.x * k, a.x * a.y * k + a.z * s, a.x * a.z * k - a.y * s,  // first column
                 a.x * a.y * k - a.z * s, c + a.y * a.y * k, a.y * a.z * k + a.x * s, a.x * a.z * k + a.y * s, a.y * a.z * k - a.x * s,
                 c + a.z * a.z * k);
}

}  // namespace

Pose poseOf(const TruthPose& pose) {
    Pose out;
    for (const Vec3d& axisAngle : pose.rotations) {
        const double angle = glm::length(axisAngle);
        out.localRotations.push_back(angle > 1e-12 ? Quatf(glm::angleAxis(angle, axisAngle / angle)) : Quatf(1, 0, 0, 0));
    }
    out.rootTranslation = Vec3f(pose.translation);
    return out;
}

std::vector<Mat3x4d> truthTransforms(const std::vector<JointData>& joints, const TruthPose& pose) {
    std::vector<Mat3x4d> global(joints.size());
    for (size_t j = 0; j < joints.size(); ++j) {
        const Mat3d r = rotationOf(pose.rotations[j]);
        const Vec3d p(joints[j].restPosition), t = p - r * p;
        if (joints[j].parent < 0) {
            global[j] = Mat3x4d(r[0], r[1], r[2], t + pose.translation);
            continue;
        }
        const Mat3x4d& g = global[joints[j].parent];
        const Mat3d gr(g[0], g[1], g[2]), turned = gr * r;
        global[j] = Mat3x4d(turned[0], turned[1], turned[2], gr * t + g[3]);
    }
    return global;
}

}  // namespace dpl
