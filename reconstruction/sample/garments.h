// SPDX-License-Identifier: Apache-2.0
// Clothes, shoes and hair as open sheets around the built-in body. Private to reconstruction/sample.
#pragma once

#include <string>

#include "reconstruction/sample/body_field.h"
#include "reconstruction/sample/implicit_mesh.h"

namespace dpl {

/** A garment as drawn: the part of the zero surface of `field` where `keep` > 0 (metres from the hem, inwards). */
struct GarmentPattern {
    ScalarField field, keep;
    Vec3f low, high;  // box that holds it
    float edgeLengthM = 0.012f;
    bool mirroredPair = false;  // meshed for x > 0 and copied to the other side (shoes)
};

struct WardrobeChoice {
    float looseness = 1;     // 0.7 … 1.4: how far cloth stands off
    float sleeveM = 0.175f;  // from the shoulder joint along the arm
    float shirtHemY = 0.835f;
    float shortsHemY = 0.565f;
    float hairM = 0.018f;  // volume on the crown
    float foldPhase = 0;
};

GarmentPattern shirtPattern(const BodyField& body, const WardrobeChoice& choice);
GarmentPattern shortsPattern(const BodyField& body, const WardrobeChoice& choice);
GarmentPattern shoePattern(const BodyField& body, const WardrobeChoice& choice);
GarmentPattern hairPattern(const BodyField& body, const WardrobeChoice& choice);

/** Meshes a pattern: an open 2-manifold sheet whose borders lie on keep = 0. */
SurfaceMesh sewGarment(const GarmentPattern& pattern, Jobs& jobs);

/** Cloth further than this below the arm's axis (along its normal, metres) belongs to the trunk. */
constexpr float kSleeveReachM = -0.108f;

/** The thickness of soles: the subject stands this much higher than the bare body. */
constexpr float kSoleM = 0.014f;

}  // namespace dpl
