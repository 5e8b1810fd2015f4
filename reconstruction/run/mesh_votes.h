// SPDX-License-Identifier: Apache-2.0
// What frames say of a mesh: its labels, its colours, and the size of their pixels on it.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Label of every triangle of `mesh`, voted by the still training frames with labels; bodyLabel where none sees it. Empty when no frame has
 *  labels. Errors: a picture cannot be read. */
Result<std::vector<uint8_t>> voteTriangleLabels(const std::vector<JointData>& joints, const MeshData& mesh,
                                                const std::vector<TrainFrame>& frames, uint8_t bodyLabel, Jobs& jobs);

/** AvatarData::trainedPixelM of these frames: the median size of a pixel at the root joint, metres. The weight of a frame is the number of
 *  joints that it shows, so close-ups count little. 0 when no frame shows a joint. */
float trainedPixelM(const std::vector<JointData>& joints, const std::vector<TrainFrame>& frames);

/** Vertex colours from training frames, for viewers without splat support and for the report's mesh baseline. Errors: as above. */
Result<std::vector<glm::u8vec4>> gatherVertexColours(const std::vector<JointData>& joints, const MeshData& mesh,
                                                     const std::vector<TrainFrame>& frames, Jobs& jobs);

}  // namespace dpl
