// SPDX-License-Identifier: Apache-2.0
// Measures how far a body fit is from the ground truth of a synthetic scan. The fit never includes this file; a test hides every truth
// file and checks that the avatar stays the same.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/subject/body/fit_body.h"

namespace dpl {

struct ErrorSpread {
    size_t count = 0;
    double mean = 0, median = 0, p95 = 0, max = 0;
};

struct KeypointTruth {
    std::string name;
    ErrorSpread mm;
};

/** How far fingertips are from the truth as their wrist sees them: in axes of the wrist and the bases of index and pinky, which the
 *  fingers do not move. Over the hands that the truth shows at least kSmallestTrueHandPx long. */
struct FingerTruth {
    ErrorSpread stillMm, movingMm;              // still frames, moving frames; all splits
    ErrorSpread stillAtRestMm, movingAtRestMm;  // the same with fingers at rest, as if they had never been fitted
};
constexpr double kSmallestTrueHandPx = 24;

struct TruthComparison {
    ErrorSpread keypointsMm;  // every keypoint of the dynamic Test frames
    std::vector<KeypointTruth> byKeypoint;
    ErrorSpread limbDegrees;                          // direction errors of the 12 limb bones, dynamic Test frames
    ErrorSpread trainKeypointsMm, staticKeypointsMm;  // dynamic Train frames; static full-body frames of both splits
    FingerTruth fingers;                              // empty where the truth holds no hands
    bool sameBody = false;                            // truth.json states that the subject was made from the same template
};

/** Reads scanRoot/truth.json (keypoints_world) and compares `shaped` in the poses of `fit`. NotFound when the scan has no truth. */
Result<TruthComparison> compareWithTruth(const std::filesystem::path& scanRoot, const Scan& scan, const BodyModel& shaped,
                                         const BodyFit& fit);

/** One keypoint of a posed body. */
struct PosedKeypoint {
    Vec3d place{0};        // world, metres
    bool present = false;  // false: the body has no keypoint of this name
};
/** The keypoints of a body at a pose, one per entry of `names`. `landmarks`: one per name, or empty. */
std::vector<PosedKeypoint> posedKeypoints(const BodyModel& shapedBody, const Pose& pose, const std::vector<std::string>& names,
                                          std::span<const LandmarkOffset> landmarks = {});

}  // namespace dpl
