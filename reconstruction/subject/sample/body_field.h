// SPDX-License-Identifier: Apache-2.0
// The built-in body as one implicit solid, left-right symmetric, with body parts placed relative to the skeleton's joints.
#pragma once

#include "reconstruction/subject/sample/field.h"
#include "reconstruction/subject/sample/skeleton.h"

namespace dpl {

/** The part of the body that a point belongs to. Skin weights blend between parts only where the surface joins them. */
enum class BodyPart : uint8_t { Torso, Head, Leg, Arm, Palm, Index, Middle, Pinky, Ring, Thumb };
constexpr int kBodyPartCount = 10;

class BodyField {
public:
    BodyField();
    /** Approximate signed distance in metres, negative inside. Accepts points of both sides (x is mirrored). */
    float distance(const Vec3f& p) const;
    /** Unit outward direction. */
    Vec3f normal(const Vec3f& p) const;
    /** The part whose own solid is nearest. Accepts points of both sides. */
    BodyPart part(const Vec3f& p) const;

    // Solids of single parts, for garments, which must not follow every groove. Only for x ≥ 0: the caller mirrors.
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

/** Wanted edge length of the mesh at a rest position, metres. Shorter on face, hands and toes. */
float bodyEdgeLength(const Vec3f& p);

}  // namespace dpl
