// SPDX-License-Identifier: Apache-2.0
// Clothes, shoes and hair as open mesh sheets around the built-in body. Private to reconstruction/subject/sample.
#pragma once

#include <string>

#include "reconstruction/subject/sample/body_field.h"
#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {

/** The shape of a garment: the part of the zero surface of `field` where `keep` > 0. `keep` is about the distance to the hem in metres. */
struct GarmentPattern {
    ScalarField field, keep;
    Vec3f low, high;  // bounding box, metres
    float edgeLengthM = 0.012f;
    bool mirroredPair = false;  // the mesh is made for x > 0 and copied to x < 0 (shoes)
};

struct WardrobeChoice {
    float looseness = 1;        // scale of the gap between cloth and body, 0.7 to 1.4
    float sleeveM = 0.175f;     // length from the shoulder joint along the arm
    float shirtHemY = 0.835f;   // height, metres
    float shortsHemY = 0.565f;  // height, metres
    float skirtHemY = 0.47f;    // height, metres
    float hairM = 0.018f;       // thickness on the crown
    float quiffM = 0.008f;      // more of it above the forehead
    float foldPhase = 0;        // radians, shifts the folds
};

/** A shirt that lies over `bottom`. */
GarmentPattern shirtPattern(const BodyField& body, const WardrobeChoice& choice, const GarmentPattern& bottom);
/** A wide skirt with folds, from the waist to the knee. */
GarmentPattern skirtPattern(const BodyField& body, const WardrobeChoice& choice);
GarmentPattern shortsPattern(const BodyField& body, const WardrobeChoice& choice);
GarmentPattern shoePattern(const BodyField& body, const WardrobeChoice& choice);
GarmentPattern hairPattern(const BodyField& body, const WardrobeChoice& choice);

/** Meshes a pattern as an open 2-manifold sheet with its borders on keep = 0. */
SurfaceMesh sewGarment(const GarmentPattern& pattern, Jobs& jobs);

/** Separates sleeve and trunk: cloth with a smaller offset from the shoulder, along the arm's upward normal, belongs to the trunk. */
constexpr float kSleeveReachM = -0.108f;

/** Thickness of the soles, by which the dressed subject stands higher than the bare body. */
constexpr float kSoleM = 0.014f;

}  // namespace dpl
