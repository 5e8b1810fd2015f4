// SPDX-License-Identifier: Apache-2.0
// Places of keypoints in space, from several views of a person who stands still.
#pragma once

#include <optional>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** One view's keypoints with its camera. */
struct KeypointView {
    Camerad camera;
    const std::vector<Keypoint>* keypoints = nullptr;
};

/** 3D positions, in scan units, of the keypoints that two or more views see with confidence; empty for the others. A few wrong detections
 *  are tolerated. */
std::vector<std::optional<Vec3d>> triangulateKeypoints(const std::vector<KeypointView>& views, size_t keypointCount);

}  // namespace dpl
