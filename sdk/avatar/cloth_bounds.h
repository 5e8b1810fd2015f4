// SPDX-License-Identifier: Apache-2.0
// Weights of garments that tear cloth in no pose that people take.
//
// Cloth whose ends follow different limbs is stretched between them: where weights change fast along an edge, the edge grows to many times
// its length, and needles stand out of the cloth. boundCloth() poses a garment in the poses of stress_poses.h and evens the weights at the
// ends of every edge that grows too long. The same code runs when garments are made, in more poses, and when a file is loaded.
// docs/reference/garments.md
#pragma once

#include <span>

#include "sdk/avatar/rig.h"

namespace dpl {

constexpr float kMostClothStretch = 1.7f;  // of an edge over its rest length: what sweeps aim at, because other poses add to it
constexpr float kTornClothStretch = 2.3f;  // a file with a longer edge is mended; more than 1.7, because weights come in steps of 1/255

/** A garment to bound, borrowed. */
struct ClothPiece {
    std::span<const Vec3f> rest;           // V, metres
    std::span<const Triangle> triangles;   // indices into `rest`
    std::span<glm::u16vec4> jointIndices;  // V
    std::span<glm::u8vec4> jointWeights;   // V, unorm8, each sums to 255
};

struct ClothBounds {
    float longestBefore = 1, longestAfter = 1;  // of an edge over its rest length, over the poses
    uint32_t evened = 0;                        // vertices whose weights have changed
};

/** For a piece with an edge beyond `torn` in one of the poses: mixes the weights at the ends of edges beyond kMostClothStretch, in a fixed
 *  number of sweeps. Another piece is left as it is, and so is one of more than 200,000 vertices. Deterministic. The rig must have passed
 *  checkRig, and indices be in range. */
ClothBounds boundCloth(const ClothPiece& piece, std::span<const JointData> joints, std::span<const Pose> poses, float torn);

/** boundCloth() for every garment of a file, in stressPoses() and from kTornClothStretch on. Nothing happens on a rig without humanoid
 * legs, or one that checkRig refuses. The mesh must have passed the checks of the file reader. */
ClothBounds boundGarments(std::span<const JointData> joints, MeshData& mesh);

/** The same for an avatar that is being made: in clothPoses(), and from kMostClothStretch on. Takes up to seconds of a core. What it
 * leaves, boundGarments() leaves alone, unless no weights hold the cloth together. */
ClothBounds boundNewGarments(std::span<const JointData> joints, MeshData& mesh);

}  // namespace dpl
