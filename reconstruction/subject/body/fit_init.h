// SPDX-License-Identifier: Apache-2.0
// The start of the fit: triangulate keypoints, align the body's torso to them, then rotate each limb bone towards its points.
#pragma once

#include <optional>
#include <vector>

#include "reconstruction/subject/body/fit_costs.h"
#include "sdk/core/result.h"

namespace dpl {

/** One view's keypoints with its camera. */
struct KeypointView {
    Camerad camera;
    const std::vector<Keypoint>* keypoints = nullptr;
};

/** 3D positions, in scan units, of the keypoints that two or more views see with confidence; empty for the others. A few wrong detections
 *  are tolerated. */
std::vector<std::optional<Vec3d>> triangulateKeypoints(const std::vector<KeypointView>& views, size_t keypointCount);

struct FitStart {
    Mat3d rootReference{1};  // world rotation of the root
    double root[kRootSize] = {};
    std::vector<double> pose;  // 3 × posed joints
    double metresPerUnit = 1;
};

/** Aligns the mean body to triangulated keypoints. `metric` false: solves the scale as well. NotFound when fewer than four points of the
 *  torso (shoulders, hips, neck, pelvis) are known. */
Result<FitStart> startFromPoints(const BodyModel& body, const KeypointChain& chain, const std::vector<std::string>& keypointNames,
                                 const std::vector<std::optional<Vec3d>>& points, bool metric);

}  // namespace dpl
