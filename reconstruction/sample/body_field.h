// SPDX-License-Identifier: Apache-2.0
// The built-in body as one implicit solid: anatomy hung on the skeleton, left-right symmetric.
#pragma once

#include "reconstruction/sample/field.h"
#include "reconstruction/sample/skeleton.h"

namespace dpl {

/** Which chain of the body a point belongs to; chains never exchange skin weights except where they grow out of each other. */
enum class BodyPart : uint8_t { Torso, Head, Leg, Arm, Palm, Index, Middle, Pinky, Ring, Thumb };
constexpr int kBodyPartCount = 10;

class BodyField {
public:
    BodyField();
    /** About metres, negative inside. Any point; sides are mirrored. */
    float distance(const Vec3f& p) const;
    /** Unit outward direction. */
    Vec3f normal(const Vec3f& p) const;
    /** The chain whose own solid is nearest. */
    BodyPart part(const Vec3f& p) const;

    // Single solids, x ≥ 0 side only (callers mirror), for garments that must not follow every groove.
    float torso(const Vec3f& p) const;
    float leg(const Vec3f& p) const;    // with the foot
    float foot(const Vec3f& p) const;   // without toes
    float arm(const Vec3f& p) const;    // shoulder to wrist
    float head(const Vec3f& p) const;   // with the neck
    float scalp(const Vec3f& p) const;  // skull and neck without face details and ears

private:
    float cranium(const Vec3f& p) const;
    float hand(const Vec3f& p) const;
    float palm(const Vec3f& p) const;
    float finger(const Vec3f& p, Finger finger) const;
    float toes(const Vec3f& p) const;
    float neck(const Vec3f& p) const;

    Tube torso_, thigh_, calf_, foot_, upperArm_, forearm_, palm_, face_, neck_;
    HandFrame hand_;
    std::array<std::array<Vec3f, 4>, kFingerCount> fingers_;
};

/** Edge length that the mesh should have at a rest position, metres: fine on face, hands and toes. */
float bodyEdgeLength(const Vec3f& p);

}  // namespace dpl
