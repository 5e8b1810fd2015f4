// SPDX-License-Identifier: Apache-2.0
// Frames as training, polish and pose fit take them: decoded pictures with cameras and poses.
#pragma once

#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/splat/train_images.h"

namespace dpl {

/** Decodes one frame with the pose given; frames without a mask are an error that names the remedy. */
Result<TrainFrame> loadTrainFrame(const ScanFrame& frame, const Pose& pose);

/** Usable frames of a split that have a mask, with the registered poses. `indices` (into Scan::frames) may be null. */
Result<std::vector<TrainFrame>> loadTrainFrames(const SubjectData& subject, Split split, std::vector<size_t>* indices = nullptr);

/** Clothing label of every triangle of `mesh`, voted by still training frames that bring labels; empty when none does. */
std::vector<uint8_t> voteTriangleLabels(const std::vector<JointData>& joints, const MeshData& mesh, const std::vector<TrainFrame>& frames,
                                        Jobs& jobs);

/** AvatarData::trainedPixelM of these frames: the median of their pixels at the root joint, each frame weighing as many joints as it shows.
 * So a close-up of a hand hardly counts, and half of what was seen of the body was seen at least as coarse. 0 when no frame shows a joint.
 */
float trainedPixelM(const std::vector<JointData>& joints, const std::vector<TrainFrame>& frames);

/** Vertex colours for stock viewers and for the report's floor, gathered from training frames. */
std::vector<glm::u8vec4> gatherVertexColours(const std::vector<JointData>& joints, const MeshData& mesh,
                                             const std::vector<TrainFrame>& frames, Jobs& jobs);

}  // namespace dpl
