// SPDX-License-Identifier: Apache-2.0
// How bright pictures show each vertex.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A vertex in a picture. */
struct LightSighting {
    uint32_t vertex = 0;
    bool moving = false;      // in a moving frame
    float logBrightness = 0;  // natural logarithm of the mean of the channels, display-referred
    float weight = 0;         // > 0; the inverse of its variance, up to a factor
    Vec3f normal{0};          // unit, world, as lightFactors() turns it
};

/** A posed mesh that pictures show. One entry a vertex. normals: of any length; those of length 0 tell nothing. trust: weight over that of
 *  skin. */
struct SeenSurface {
    std::span<const Vec3f> positions, normals;
    std::span<const double> trust;
    std::span<const Triangle> triangles;
};

/** Appends the sightings of one picture, in order of vertex. */
void addLightSightings(const SeenSurface& surface, const Camerad& camera, bool moving, const FramePicture& picture,
                       std::vector<LightSighting>& sightings);

/** Sightings of vertices well inside the outline, in the frames that are no close-ups, in order of frame and vertex. Errors: a picture
 * cannot be read; Cancelled. */
Result<std::vector<LightSighting>> lightSightings(std::span<const JointData> joints, const MeshData& mesh,
                                                  std::span<const TrainFrame> frames, Jobs& jobs);

}  // namespace dpl
