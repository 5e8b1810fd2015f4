// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/gaze.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

constexpr double kNeckOfHead = 0.5;   // of the head's turn, which the neck takes
constexpr double kSoftFrom = 0.75;    // share of a limit up to which turns are exact
constexpr double kFadesFromRad = 2;   // from straight ahead; nothing is left at pi
const Vec3d kEyesM(0, 0.065, 0.075);  // from the head's joint at rest, of rigs without eyes

double smooth(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/** A direction as the turn that takes +Z to it the shortest way: angles about two axes, to the left and up. Their length is the angle. */
Vec2d turnTo(const Vec3d& direction) {
    const double across = std::hypot(direction.x, direction.y), angle = std::atan2(across, direction.z);
    return across > 0 ? Vec2d(direction.x, direction.y) * (angle / across) : Vec2d(angle, 0);
}

Quatd rotationOf(const Vec2d& turn) {
    const double angle = glm::length(turn), s = angle > 1e-9 ? std::sin(0.5 * angle) / angle : 0.5;
    return {std::cos(0.5 * angle), -s * turn.y, s * turn.x, 0};
}

Vec2d limited(const Vec2d& turn, const Vec2f& limitRad) {
    const double r = std::hypot(turn.x / double(limitRad.x), turn.y / double(limitRad.y));
    if (r <= kSoftFrom) return turn;
    return turn * ((kSoftFrom + (1 - kSoftFrom) * std::tanh((r - kSoftFrom) / (1 - kSoftFrom))) / r);
}

double ahead(const Vec2d& turn) {
    return 1 - smooth(kFadesFromRad, glm::pi<double>(), glm::length(turn));
}

/** The rotation that takes a part from where it looks to `share` of the way to `to`. */
Quatd towards(const Vec2d& from, const Vec2d& to, double share) {
    return rotationOf(from + share * (to - from)) * glm::conjugate(rotationOf(from));
}

Quatf placed(const Quatd& q) {
    return Quatf(glm::normalize(q));
}

/** Rotations and places of joints in a pose. */
class Posed {
public:
    Posed(std::span<const JointData> joints, std::span<const Mat3x4f> transforms) : joints_(joints), transforms_(transforms) {}
    Quatd rotation(int32_t joint) const {
        if (joint < 0) return {1, 0, 0, 0};
        const Mat3x4f& g = transforms_[size_t(joint)];
        return glm::normalize(Quatd(glm::quat_cast(Mat3f(g[0], g[1], g[2]))));
    }
    Vec3d at(size_t joint) const { return Vec3d(transforms_[joint] * Vec4f(joints_[joint].restPosition, 1)); }
    Quatd above(size_t joint) const { return rotation(joints_[joint].parent); }

private:
    std::span<const JointData> joints_;
    std::span<const Mat3x4f> transforms_;
};

double distanceToLine(const Vec3d& point, const Vec3d& a, const Vec3d& b) {
    const Vec3d along = b - a;
    const double length2 = glm::dot(along, along), t = length2 > 0 ? std::clamp(glm::dot(point - a, along) / length2, 0.0, 1.0) : 0.0;
    return glm::length(point - (a + t * along));
}

Status checkGaze(const Gaze& gaze) {
    for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(gaze.target[axis])) return fail(Code::InvalidArgument, "the target is not finite");
    for (const auto& [name, weight] : {std::pair("headWeight", gaze.headWeight), std::pair("eyeWeight", gaze.eyeWeight)})
        if (!(weight >= 0 && weight <= 1)) return fail(Code::InvalidArgument, "{} is {}; weights are 0 to 1", name, weight);
    for (const Vec2f& limit : {gaze.headLimitRad, gaze.eyeLimitRad})
        for (int axis = 0; axis < 2; ++axis)
            if (!(limit[axis] > 0 && limit[axis] <= kLargestGazeLimitRad))
                return fail(Code::InvalidArgument, "a limit is {} rad; limits are above 0 and at most {} (90 degrees)", limit[axis],
                            kLargestGazeLimitRad);
    return {};
}

}  // namespace

Result<GazeJoints> GazeJoints::of(std::span<const JointData> joints) {
    const BoneMap bones = bonesOf(joints);
    const auto head = findBone(bones, "head");
    if (!head) {
        std::string names;
        for (const JointData& joint : joints) names += (names.empty() ? "" : ", ") + joint.name;
        return fail(Code::Unsupported, "no joint is known as the head, so nothing can look; the avatar has: {}", names);
    }
    GazeJoints who{*head, {}, {findBone(bones, "leftEye"), findBone(bones, "rightEye")}};
    const auto neck = findBone(bones, "neck");
    for (int32_t j = joints[*head].parent; neck && j >= 0; j = joints[size_t(j)].parent)
        if (size_t(j) == *neck) who.neck = neck;
    return who;
}

Vec2d gazeTurn(const Quatf& localRotation) {
    return turnTo(glm::normalize(Quatd(localRotation)) * Vec3d(0, 0, 1));
}

Status lookAt(std::span<const JointData> joints, const GazeJoints& who, const Gaze& gaze, Pose& pose, std::vector<Mat3x4f>& transforms) {
    DPL_RETURN_IF_ERROR(checkGaze(gaze));
    jointTransforms(joints, pose, transforms);
    const Posed before(joints, transforms);
    const Vec3d target(gaze.target);
    const size_t lowest = who.neck.value_or(who.head);
    const Quatd headTurned = before.rotation(int32_t(who.head)), trunk = before.above(lowest);
    Vec3d eyes = before.at(who.head) + headTurned * kEyesM;
    if (who.eyes[0] && who.eyes[1]) eyes = 0.5 * (before.at(*who.eyes[0]) + before.at(*who.eyes[1]));
    const double distanceM = distanceToLine(target, before.at(lowest), eyes);
    if (distanceM < kGazeInsideM)
        return fail(Code::InvalidArgument, "the target lies {} m from the line between neck and eyes, which is inside the avatar itself",
                    distanceM);
    const Vec2d wanted = turnTo(glm::conjugate(trunk) * (target - eyes));
    const double share = smooth(kGazeInsideM, kGazeClearM, distanceM) * ahead(wanted);

    if (const double headShare = share * double(gaze.headWeight); headShare > 0) {
        const Vec2d from = turnTo(glm::conjugate(trunk) * headTurned * Vec3d(0, 0, 1)), to = limited(wanted, gaze.headLimitRad);
        const Quatd headNow = trunk * towards(from, to, headShare) * glm::conjugate(trunk) * headTurned;
        Quatd above = before.above(who.head);
        if (who.neck) {
            const Quatd turn = towards(from, to, kNeckOfHead * headShare);
            pose.localRotations[*who.neck] = placed(turn * Quatd(pose.localRotations[*who.neck]));
            above = trunk * turn * glm::conjugate(trunk) * above;
        }
        pose.localRotations[who.head] = placed(glm::conjugate(above) * headNow);
        jointTransforms(joints, pose, transforms);
    }
    const Posed now(joints, transforms);
    for (const auto& eye : who.eyes) {
        if (!eye) continue;
        const Quatd head = now.above(*eye), local = glm::normalize(Quatd(pose.localRotations[*eye]));
        const Vec2d toTarget = turnTo(glm::conjugate(head) * (target - now.at(*eye)));
        const double eyeShare = share * ahead(toTarget) * double(gaze.eyeWeight);
        if (!(eyeShare > 0)) continue;
        const Quatd turn = towards(turnTo(local * Vec3d(0, 0, 1)), limited(toTarget, gaze.eyeLimitRad), eyeShare);
        pose.localRotations[*eye] = placed(turn * local);
    }
    return {};
}

}  // namespace dpl
