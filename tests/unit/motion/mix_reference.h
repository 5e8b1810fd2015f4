// SPDX-License-Identifier: Apache-2.0
// Mixing and looking in double precision, from the formulas of docs/reference/mixing.md and not from the code of the SDK.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/motion/gaze.h"

namespace dpl::test {

/** Angle between two rotations, radians; exact for small ones. */
inline double angleBetween(const Quatd& a, const Quatd& b) {
    const Quatd d = glm::conjugate(glm::normalize(a)) * glm::normalize(b);
    return 2 * std::atan2(std::hypot(d.x, d.y, d.z), std::abs(d.w));
}

/** The mix of two rotations by any weights, as a turn from the first about the axis of the shorter turn between them: if half of the angle
 *  between them is w, the normalised sum a q0 + b q1 lies atan2(b sin w, a + b cos w) away from q0 on the sphere of quaternions. */
inline Quatd mixOfTwo(const Quatd& first, const Quatd& second, double a, double b) {
    const Quatd q0 = glm::normalize(first), q1 = glm::normalize(second);
    Quatd turn = glm::conjugate(q0) * q1;
    if (turn.w < 0) turn = Quatd(-turn.w, -turn.x, -turn.y, -turn.z);
    const double sine = std::hypot(turn.x, turn.y, turn.z);
    if (sine < 1e-15) return q0;
    const double angle = std::atan2(b * sine, a + b * turn.w);
    return q0 * Quatd(std::cos(angle), std::sin(angle) * Vec3d(turn.x, turn.y, turn.z) / sine);
}

/** The normalised sum of rotations whose quaternions lie on the side of the first. Exact reference where all lie within 90 degrees. */
inline Quatd mixOfMany(std::span<const Quatd> rotations, std::span<const double> weights) {
    Vec4d sum(0);
    for (size_t i = 0; i < rotations.size(); ++i) {
        const Quatd q = glm::normalize(rotations[i]);
        const Vec4d v(q.x, q.y, q.z, q.w), f(rotations[0].x, rotations[0].y, rotations[0].z, rotations[0].w);
        sum += (glm::dot(v, f) < 0 ? -weights[i] : weights[i]) * v;
    }
    sum = glm::normalize(sum);
    return {sum.w, sum.x, sum.y, sum.z};
}

// ---- looking

/** exp of the cross product with v: the turn about v by |v|. */
inline Mat3d turnBy(const Vec3d& v) {
    const double angle = glm::length(v);
    if (angle < 1e-14) return Mat3d(1);
    const Vec3d n = v / angle;
    const Mat3d k(0, n.z, -n.y, -n.z, 0, n.x, n.y, -n.x, 0);
    return Mat3d(1) + std::sin(angle) * k + (1 - std::cos(angle)) * (k * k);
}

/** The shortest turn from +Z to a direction, as an angle times an axis, which has no part along z. */
inline Vec3d shortestFromZ(const Vec3d& direction) {
    const Vec3d d = glm::normalize(direction), axis = glm::cross(Vec3d(0, 0, 1), d);
    const double sine = glm::length(axis);
    return sine > 1e-300 ? axis / sine * std::atan2(sine, d.z) : Vec3d(0, d.z < 0 ? glm::pi<double>() : 0, 0);
}

struct ReferenceGaze {
    std::vector<Quatd> local;

    static double step(double a, double b, double x) {
        const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
        return t * t * (3 - 2 * t);
    }
    /** v: about x (minus up) and y (left). */
    static Vec3d held(const Vec3d& v, double leftRad, double upRad) {
        const double r = std::sqrt(v.y * v.y / (leftRad * leftRad) + v.x * v.x / (upRad * upRad));
        return r <= 0.75 ? v : v * ((0.75 + 0.25 * std::tanh((r - 0.75) / 0.25)) / r);
    }
    static double front(const Vec3d& v) { return 1 - step(2, glm::pi<double>(), glm::length(v)); }
    static Mat3d swing(const Vec3d& from, const Vec3d& to, double share) {
        return turnBy(from + share * (to - from)) * glm::transpose(turnBy(from));
    }
    static Quatd quat(const Mat3d& m) { return glm::normalize(glm::quat_cast(m)); }

    ReferenceGaze(std::span<const JointData> joints, const GazeJoints& who, const Gaze& gaze, const Pose& pose) {
        for (const Quatf& q : pose.localRotations) local.push_back(glm::normalize(Quatd(q)));
        std::vector<Mat3d> world;
        std::vector<Vec3d> at;
        const auto walk = [&] {
            world.assign(joints.size(), Mat3d(1)), at.assign(joints.size(), Vec3d(0));
            for (size_t j = 0; j < joints.size(); ++j) {
                const int32_t p = joints[j].parent;
                const Vec3d rest(joints[j].restPosition);
                world[j] = (p < 0 ? Mat3d(1) : world[size_t(p)]) * glm::mat3_cast(local[j]);
                at[j] = p < 0 ? rest + Vec3d(pose.rootTranslation)
                              : at[size_t(p)] + world[size_t(p)] * (rest - Vec3d(joints[size_t(p)].restPosition));
            }
        };
        const auto above = [&](size_t j) { return joints[j].parent < 0 ? Mat3d(1) : world[size_t(joints[j].parent)]; };
        walk();
        const size_t low = who.neck ? *who.neck : who.head;
        const Mat3d trunk = above(low), head = world[who.head];
        const Vec3d target(gaze.target);
        const Vec3d eyes =
            who.eyes[0] && who.eyes[1] ? 0.5 * (at[*who.eyes[0]] + at[*who.eyes[1]]) : at[who.head] + head * Vec3d(0, 0.065, 0.075);
        double nearest = 1e300;  // of 10,000 places along the line
        for (int i = 0; i <= 10000; ++i) nearest = std::min(nearest, glm::length(target - glm::mix(at[low], eyes, i * 1e-4)));
        const Vec3d wanted = shortestFromZ(glm::transpose(trunk) * (target - eyes));
        const double share = step(0.12, 0.24, nearest) * front(wanted);
        const Vec3d from = shortestFromZ(glm::transpose(trunk) * head * Vec3d(0, 0, 1));
        const Vec3d to = held(wanted, double(gaze.headLimitRad.x), double(gaze.headLimitRad.y));
        const Mat3d headNow = trunk * swing(from, to, share * double(gaze.headWeight)) * glm::transpose(trunk) * head;
        if (who.neck) local[low] = quat(swing(from, to, 0.5 * share * double(gaze.headWeight)) * glm::mat3_cast(local[low]));
        walk();
        local[who.head] = quat(glm::transpose(above(who.head)) * headNow);
        walk();
        for (const auto& eye : who.eyes) {
            if (!eye) continue;
            const Vec3d aim = shortestFromZ(glm::transpose(above(*eye)) * (target - at[*eye]));
            const Vec3d now = shortestFromZ(glm::mat3_cast(local[*eye]) * Vec3d(0, 0, 1));
            const Vec3d then = held(aim, double(gaze.eyeLimitRad.x), double(gaze.eyeLimitRad.y));
            local[*eye] = quat(swing(now, then, share * front(aim) * double(gaze.eyeWeight)) * glm::mat3_cast(local[*eye]));
        }
    }
};

}  // namespace dpl::test
