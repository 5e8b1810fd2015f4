// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/pose_prior.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

constexpr double kFree = 3.1;
constexpr double kTail = 2.5;         // Geman–McClure scale in σ; robust, because a limb is either near its rest pose or far from it
constexpr double kMinBendRad = 0.17;  // below 10° the rest pose does not define the hinge's axis

Vec3d place(const BodyModel& body, int32_t joint) {
    return Vec3d(body.joints[size_t(joint)].restPosition);
}

/** Hinge axes [flexion, twist along the lower bone, their normal] and the bend at rest. */
struct Hinge {
    Mat3d axes{1};
    double restBendRad = 0;
};

Hinge hinge(const BodyModel& body, int32_t upper, int32_t middle, int32_t lower, bool knee) {
    const Vec3d above = glm::normalize(place(body, middle) - place(body, upper)),
                below = glm::normalize(place(body, lower) - place(body, middle));
    const Vec3d cross = glm::cross(above, below);
    Hinge h;
    h.restBendRad = std::atan2(glm::length(cross), glm::dot(above, below));
    // Elbows move the hand forward (+Z), knees move the foot back. A clear bend at rest defines an elbow's axis better.
    Vec3d axis = knee ? Vec3d(1, 0, 0) : h.restBendRad > kMinBendRad ? cross : glm::cross(above, Vec3d(0, 0, 1));
    const Vec3d twist = below;
    axis = glm::normalize(axis - glm::dot(axis, twist) * twist);
    if (knee) h.restBendRad = std::max(0.0, -std::asin(std::clamp(glm::dot(glm::cross(above, below), -axis), -1.0, 1.0)));
    h.axes = Mat3d(axis, twist, glm::cross(axis, twist));
    return h;
}

Mat3d alongBone(const Vec3d& direction) {
    const Vec3d twist = glm::normalize(direction);
    const Vec3d side = glm::normalize(glm::cross(std::abs(twist.z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(1, 0, 0), twist));
    return Mat3d(side, twist, glm::cross(side, twist));
}

}  // namespace

std::vector<JointPrior> posePriors(const BodyModel& body) {
    std::vector<JointPrior> priors;
    const Vec3d free(kFree);
    const auto add = [&](std::string_view bone, Mat3d axes, Vec3d sigma, Vec3d low, Vec3d high, double acceleration, double sway,
                         Vec3d tail = Vec3d(0)) {
        const int32_t joint = findHumanoid(body, bone);
        if (joint > 0) priors.push_back({uint32_t(joint), axes, sigma, tail, low, high, acceleration, sway});
    };
    const Mat3d world(1.0);
    for (const std::string_view bone : {"spine", "chest", "upperChest"})
        add(bone, world, {0.09, 0.12, 0.08}, Vec3d(-0.8), Vec3d(0.8), 0.315, 0.006);
    for (const std::string_view bone : {"neck", "head"}) {
        add(bone, world, {0.12, 0.25, 0.12}, Vec3d(-1), Vec3d(1), 0.525, 0.015);
        if (findHumanoid(body, bone) > 0) priors.back().shakenRadS2 = priors::kShakeRadS2;
    }
    for (const bool left : {true, false}) {
        const std::string side = left ? "left" : "right";
        const auto joint = [&](const char* bone) { return findHumanoid(body, side + bone); };
        const int32_t upperArm = joint("UpperArm"), lowerArm = joint("LowerArm"), hand = joint("Hand");
        const int32_t upperLeg = joint("UpperLeg"), lowerLeg = joint("LowerLeg"), foot = joint("Foot");
        add(side + "Shoulder", world, {0.05, 0.12, 0.25}, Vec3d(-0.7), Vec3d(0.7), 1.05, 0.0);
        if (upperArm >= 0 && lowerArm >= 0)
            add(side + "UpperArm", alongBone(place(body, lowerArm) - place(body, upperArm)), {0.35, 0.45, 0.35}, -free, free, 5, 0.02,
                {kTail, 0, kTail});
        if (upperArm >= 0 && lowerArm >= 0 && hand >= 0) {
            const Hinge h = hinge(body, upperArm, lowerArm, hand, false);
            // Forearms roll by a radian in everyday motion, and a rotation vector mixes roll with bend, so a tight prior on roll would
            // bend the elbow the wrong way.
            add(side + "LowerArm", h.axes, {0.35, 0.4, 0.1}, {-h.restBendRad - 0.05, -1.5, -0.3}, {2.6, 1.5, 0.3}, 9, 0.02, Vec3d(kTail));
            add(side + "Hand", h.axes, {0.2, 0.2, 0.2}, Vec3d(-1.2), Vec3d(1.2), 1.05, 0.02);
        }
        if (upperLeg >= 0 && lowerLeg >= 0)
            add(side + "UpperLeg", world, {0.15, 0.1, 0.2}, {-2.4, -0.8, -1.2}, {0.8, 0.8, 1.2}, 2.625, 0.0, {kTail, 0, 0});
        if (upperLeg >= 0 && lowerLeg >= 0 && foot >= 0) {
            const Hinge h = hinge(body, upperLeg, lowerLeg, foot, true);
            add(side + "LowerLeg", h.axes, {0.15, 0.05, 0.03}, {-h.restBendRad - 0.05, -0.4, -0.2}, {2.6, 0.4, 0.2}, 3.15, 0.0,
                {kTail, 0, 0});
        }
        add(side + "Foot", world, {0.15, 0.08, 0.08}, Vec3d(-0.9), Vec3d(0.9), 1.05, 0.0);
    }
    std::sort(priors.begin(), priors.end(), [](const JointPrior& a, const JointPrior& b) { return a.joint < b.joint; });
    return priors;
}

std::vector<uint32_t> jointsOf(const std::vector<JointPrior>& priors) {
    std::vector<uint32_t> joints;
    for (const JointPrior& p : priors) joints.push_back(p.joint);
    return joints;
}

}  // namespace dpl
