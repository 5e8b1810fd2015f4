// SPDX-License-Identifier: Apache-2.0
// Where splats start: spread over the mesh by area, coloured from the training pictures.
#pragma once

#include <vector>

#include "reconstruction/splat/train_images.h"
#include "reconstruction/splat/trainable.h"

namespace dpl {

struct InitSettings {
    uint32_t splatCount = 60000;
    uint32_t shDegree = 1;
    std::vector<uint8_t> clothLabels{2, 3};
    std::vector<uint8_t> openLabels{4};  // triangles with these labels draw from both sides (hair)
};

/** kSplatSingleFace and kSplatCloth of every triangle (docs/reference/gate.md): single-face except open labels and faces within two rings
 *  of a boundary edge. Vertices at one place count as one, so seams are no boundary. labels may be empty (all body). */
std::vector<uint8_t> triangleFlags(std::span<const Vec3f> restPositions, std::span<const Triangle> triangles,
                                   std::span<const uint8_t> labels, const InitSettings& settings);

/** In-plane size floor 0.35/ν of every triangle, ν the highest px/m at which any frame saw it; triangles that no frame saw take the
 *  median. Metres. */
std::vector<float> sizeFloors(std::span<const JointData> joints, const MeshData& mesh, std::span<const TrainFrame> frames, Jobs& jobs);

/** At least one splat for each valid triangle, the rest by area; s = 0.8·spacing, opacity 0.8. SH coefficient 0 is the mean colour in the
 *  frames, weighted by cos²θ of the visible surface; moving frames weigh a fifth of still ones. */
TrainableSplats initialSplats(std::span<const JointData> joints, const MeshData& mesh, std::span<const uint8_t> flags,
                              std::span<const float> floors, std::span<const TrainFrame> frames, const InitSettings& settings,
                              uint64_t seed, Jobs& jobs);

}  // namespace dpl
