// SPDX-License-Identifier: Apache-2.0
// The light of the scene, from how the brightness of each vertex follows its normal. docs/reference/light.md
#pragma once

#include <span>

#include "reconstruction/training/light/light_sightings.h"

namespace dpl {

struct LightFit {
    LightData light;
    // Weighted root mean square of the logarithm of brightness of moving sightings, each about the mean of its vertex: without and with
    // the light. 0 without moving sightings.
    double strayBefore = 0, strayAfter = 0;
};

/** Least squares of  log brightness = log albedo of the vertex + log E(normal)  by Gauss–Newton, robust (Huber). No light where fewer than
 *  200 vertices are seen both still and moving. Deterministic. */
LightFit fitLight(std::span<const LightSighting> sightings, size_t vertexCount);

/** lightSightings() and fitLight(). No light with fewer than 12 moving frames, as no correctives of the pose are made of them. Errors:
 * those of lightSightings(). */
Result<LightFit> findLight(std::span<const JointData> joints, const MeshData& mesh, std::span<const TrainFrame> frames, Jobs& jobs);

}  // namespace dpl
