// SPDX-License-Identifier: Apache-2.0
// Measuring only: how far a body fit is from the ground truth of a synthetic scan. Nothing in the fit includes this;
// a test hides every truth file and gets the same avatar.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/body/fit_body.h"

namespace dpl {

struct ErrorSpread {
    size_t count = 0;
    double mean = 0, median = 0, p95 = 0, max = 0;
};

struct KeypointTruth {
    std::string name;
    ErrorSpread mm;
};

struct TruthComparison {
    ErrorSpread keypointsMm;  // dynamic Test frames, every keypoint
    std::vector<KeypointTruth> byKeypoint;
    ErrorSpread limbDegrees;                          // dynamic Test frames, directions of the 12 limb bones
    ErrorSpread trainKeypointsMm, staticKeypointsMm;  // dynamic Train frames; static full-body frames of both splits
};

/** Reads scanRoot/truth.json (keypoints_world) and compares. NotFound when the scan has no truth. */
Result<TruthComparison> compareWithTruth(const std::filesystem::path& scanRoot, const Scan& scan, const BodyModel& body,
                                         const BodyFit& fit);

/** World places of a body's keypoints at a pose, in the order of `names`; the mean of the body for a name it lacks is not made up:
 *  `present` is false there. Metres. */
struct PosedKeypoint {
    Vec3d place{0};
    bool present = false;
};
std::vector<PosedKeypoint> posedKeypoints(const BodyModel& shapedBody, const Pose& pose, const std::vector<std::string>& names);

}  // namespace dpl
