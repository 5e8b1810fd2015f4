// SPDX-License-Identifier: Apache-2.0
// How far the garments of an avatar lie from those of the truth (docs/reference/metrics.md, "Garments").
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/judging/ladder/true_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A garment that the avatar and the truth both have. Indices are into the whole vertex arrays. */
struct GarmentPair {
    std::string name;                 // of the avatar's layer, which is the label of the true parts
    std::vector<Triangle> avatar;     // its triangles
    std::vector<Triangle> truth;      // of the true garment
    std::vector<Triangle> seenTruth;  // those of the truth that pictures show: no picture tells where the others are
};

/** Symmetric nearest distance of a garment, metres: the mean over the area of the avatar's garment of the distance to the true one, the
 *  mean over the seen area of the true one of the distance to the avatar's, and the mean of both. Triangle centres stand for their
 *  triangles. 0 when a surface has no area. Deterministic. */
double garmentDistanceM(const GarmentPair& garment, std::span<const Vec3f> avatarPositions, std::span<const Vec3f> truePositions,
                        Jobs& jobs);

/** The avatar's garment layers whose label a simulated part of the truth has, if pictures show it. Other parts move as they are skinned,
 *  and tell nothing of cloth. `seen`: one byte a true triangle. */
std::vector<GarmentPair> garmentPairs(const MeshData& avatar, const TrueMesh& truth, std::span<const uint8_t> seen);

}  // namespace dpl
