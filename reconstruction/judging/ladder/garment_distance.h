// SPDX-License-Identifier: Apache-2.0
// How far the garments of an avatar lie from those of the truth (docs/reference/metrics.md, "Garments").
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/judging/ladder/carried_points.h"
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

/** Mean of the distance from the vertices of the avatar's garment to the places where they belong, metres, over the area that the garment
 *  has at rest. A garment that slides along the true one is as far off as it slid. All arrays: V. Deterministic. */
double pointDistanceM(const GarmentPair& garment, std::span<const Vec3f> restPositions, std::span<const Vec3f> positions,
                      std::span<const Vec3f> places);

/** Places of the true garment on which the vertices of the avatar's garment lie in still frames; the true surface carries them. */
class GarmentPlaces {
public:
    /** One still frame: the avatar's vertices with their normals, and the true surface. */
    struct Still {
        std::vector<Vec3f> positions, normals, surface;
    };
    /** Each vertex takes the nearest place to its mean over the stills that a picture shows and that faces as it does. At least one still.
     */
    GarmentPlaces(const GarmentPair& garment, std::span<const Still> stills, Jobs& jobs);

    /** Where the places are when the true surface is `surface`: V entries; those of other vertices are 0. */
    std::vector<Vec3f> at(std::span<const Vec3f> surface) const;

private:
    size_t vertexCount_;  // V
    std::vector<uint32_t> vertices_;
    std::optional<CarriedPoints> points_;  // one of each of vertices_
};

/** The avatar's garment layers whose label a simulated part of the truth has, if pictures show it. Other parts move as they are skinned,
 *  and tell nothing of cloth. `seen`: one byte a true triangle. */
std::vector<GarmentPair> garmentPairs(const MeshData& avatar, const TrueMesh& truth, std::span<const uint8_t> seen);

}  // namespace dpl
