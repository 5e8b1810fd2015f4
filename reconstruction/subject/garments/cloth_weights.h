// SPDX-License-Identifier: Apache-2.0
// Skin weights of garments, from the body below them.
//
// A vertex starts with the weights of the body point below it (wornBodyBelow). followBody() spreads them, so that a skirt spans the legs.
// Then steps along edges are limited and rows are cut to four joints. docs/reference/garments.md
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct ClothWeights {
    std::vector<glm::u16vec4> joints;
    std::vector<glm::u8vec4> weights;  // unorm8, each sums to 255
    std::vector<float> distanceM;      // from the closest body point that faces the same way
    float largestStep = 0;             // of a joint's weight along an edge
};

/** below: of each vertex, wornBodyBelow(). worldFromRest: of every joint, in the pose that `piece` is in. `body` is at rest. Cloth that
 *  sinks into the body in a stress pose (sdk/avatar/stress_poses.h) follows the body more closely; cloth that tears is evened
 * (sdk/avatar/cloth_bounds.h). Errors: Internal when the sparse solve fails. */
Result<ClothWeights> clothWeights(const SurfaceMesh& piece, std::span<const SurfacePoint> below, const MeshData& body,
                                  std::span<const JointData> joints, std::span<const Mat3x4f> worldFromRest, Jobs& jobs);

/** Rest positions of posed vertices: the inverse of linear blend skinning. A vertex whose opposing joints cancel (|det| ≤ 0.25) moves
 *  with its neighbours. worldFromRest: of every joint. */
std::vector<Vec3f> unposed(const SurfaceMesh& posed, const ClothWeights& weights, std::span<const Mat3x4f> worldFromRest);

}  // namespace dpl
