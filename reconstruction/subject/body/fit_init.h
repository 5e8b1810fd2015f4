// SPDX-License-Identifier: Apache-2.0
// The start of the fit: align the body's torso to them, then rotate each limb bone towards its points.
#pragma once

#include <optional>
#include <vector>

#include "reconstruction/subject/body/fit_costs.h"
#include "sdk/core/result.h"

namespace dpl {

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
