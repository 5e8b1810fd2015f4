// SPDX-License-Identifier: Apache-2.0
// How wide an avatar's trunk and thighs are, so that hands can be kept out of them. Formulas: docs/reference/driving.md.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

class BodyShape {
public:
    /** Measures the mesh at rest: clothes count. Empty if the rig has no hips, or the mesh does not surround it. */
    static BodyShape of(std::span<const JointData> joints, const MeshData& mesh);

    bool empty() const { return tubes_.empty(); }

    /** What lies inside the body: by how far, metres, and the way out, unit, in the world. */
    struct Inside {
        float depthM = 0;
        Vec3f outward{0};
    };
    /** The deepest place of a ball in the posed body; none if it touches nothing. worldFromRest: jointTransforms of the pose. */
    std::optional<Inside> inside(const Vec3f& centre, float radiusM, std::span<const Mat3x4f> worldFromRest) const;

    /** Half of the thickness of the hand, and the radius of the lower arm, metres. side: 0 left, 1 right. */
    float handM(size_t side) const { return handM_[side]; }
    float lowerArmM(size_t side) const { return lowerArmM_[side]; }

private:
    static constexpr size_t kAround = 24, kAlong = 10;
    /** The surface around a bone at rest: radii by place along it and angle around it. */
    struct Tube {
        size_t joint = 0;
        Vec3f from{0}, along{0}, across{0}, third{0};  // axes: unit, at right angles
        float beginM = 0, endM = 0;                    // along the axis
        std::vector<float> radiiM;                     // kAlong × kAround

        float radiusAt(float alongM, float angleRad) const;
    };
    static std::optional<Tube> tubeOf(std::span<const JointData> joints, const MeshData& mesh, size_t joint, const Vec3f& to);

    std::vector<Tube> tubes_;
    float handM_[2] = {0.015f, 0.015f}, lowerArmM_[2] = {0.04f, 0.04f};
};

/** Moves wrists out of the body, so that palms, fingers and lower arms touch it instead of cutting through. Hands keep their rotation,
 * elbows bend. A hand moves by at most kFarthestPushM. */
constexpr float kFarthestPushM = 0.15f;

class HandGuard {
public:
    /** body: of that rig. The joints must outlive this. An empty body guards nothing. */
    HandGuard(BodyShape body, std::span<const JointData> joints);

    /** Whether the rig has this arm, and its upper joint. side: 0 left, 1 right. */
    std::optional<size_t> upperArm(size_t side) const {
        return arms_[side].balls.empty() ? std::nullopt : std::optional(arms_[side].upper);
    }
    /** By how much the left and the right wrist must move, metres, world. The pose must have passed checkPose. */
    using Pushes = std::array<Vec3f, 2>;
    Pushes pushes(const Pose& pose);
    /** Moves the wrists. Pushes of 0 change nothing. */
    void push(const Pushes& pushes, Pose& pose);

private:
    /** A ball of the arm: its centre is a point of a joint at rest, and moves by `share` of what the wrist moves. */
    struct Ball {
        size_t joint = 0;
        Vec3f rest{0};
        float radiusM = 0, share = 1;
    };
    struct Arm {
        size_t upper = 0, lower = 0, hand = 0;
        std::vector<Ball> balls;  // none: the rig lacks the arm
    };
    Vec3f pushFor(const Arm& arm) const;

    BodyShape body_;
    std::span<const JointData> joints_;
    std::array<Arm, 2> arms_;     // left, right
    std::vector<Mat3x4f> world_;  // of the pose that is being guarded
};

}  // namespace dpl
