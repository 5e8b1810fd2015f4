// SPDX-License-Identifier: Apache-2.0
// Where the fit starts: keypoints triangulated over still frames, the body's torso laid onto them, limbs swung to meet them.
#pragma once

#include <optional>
#include <vector>

#include "reconstruction/body/fit_costs.h"
#include "sdk/core/result.h"

namespace dpl {

/** One view's keypoints with its camera. */
struct KeypointView {
    Camerad camera;
    const std::vector<Keypoint>* keypoints = nullptr;
};

/** 3D places of keypoints seen with confidence in two or more views, scan units; nothing for the others. Robust to a few wrong ones. */
std::vector<std::optional<Vec3d>> triangulateKeypoints(const std::vector<KeypointView>& views, size_t keypointCount);

struct FitStart {
    Mat3d rootReference{1};  // root turn, world
    double root[kRootSize] = {};
    std::vector<double> pose;  // 3 × posed joints
    double metresPerUnit = 1;
};

/** Lays the mean body onto triangulated keypoints. `metric` false solves the scale too. NotFound when the torso (shoulders, hips, neck,
 *  pelvis) has fewer than four points. */
Result<FitStart> startFromPoints(const BodyModel& body, const KeypointChain& chain, const std::vector<std::string>& keypointNames,
                                 const std::vector<std::optional<Vec3d>>& points, bool metric);

}  // namespace dpl
