// SPDX-License-Identifier: Apache-2.0
// Turns the fingers of a fitted body by the 2D keypoints of its hands (hand_keypoints.h). Solved with Ceres on one thread; deterministic.
//
//   min Σ_frames Σ_k ρ( (π(wrist_f, X_k(θ_f)) − x_fk) · confidence / σ ) + priors(θ) + smoothness in time
//   θ   20 hinges a hand (hand_rig.h), inside their limits: one θ for all still frames, one for each moving frame
//
// The body, its arms and its places stay. The body fit tells a wrist's turn from a single keypoint, so each frame solves where its hand
// really is along with the fingers.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "reconstruction/input/capture/pose_precision.h"
#include "reconstruction/subject/body/fit_body.h"

namespace dpl {

/** What was found of the fingers of one hand. */
struct HandFit {
    bool left = false;
    bool turned = false;      // the still pose turns its fingers; false: at rest
    size_t stillFrames = 0;   // that show it well enough
    size_t movingFrames = 0;  // that show it well enough, in all splits
    size_t posedFrames = 0;   // of these: with fingers of their own
    double medianPx = 0;      // distance of its points from the fitted fingers, in still train frames and in posed ones
    std::vector<std::optional<PosePrecision>> precisions;  // one a frame: of turned fingers that it shows; the root's rows are 0
};

/** Turns the fingers in fit.staticPose and fit.poses. `body` is the one that was fitted; hands[f] holds the points of
 *  scan.frames[f] in the order of handKeypointNames(), or nothing. Gives each hand that the body has, left first;
 *  nothing where no frame has points, and then the fit stays as it is.
 *
 *  Still frames share one pose, found in still train frames. A moving frame has its own where its hand is at least kSmallestHandPx long,
 * sure, and explained better by it (kFingerGain); else it keeps the still pose. A hand that is never explained better than by the rest pose
 *  keeps that. Held-out frames are posed afterwards, with train frames fixed. Errors: InvalidArgument for lists of the wrong size,
 *  CorruptData for points that are not finite, Cancelled. */
Result<std::vector<HandFit>> fitFingers(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> hands,
                                        BodyFit& fit);

/** A sentence for the log and the report. */
std::string describeHand(const HandFit& hand);

/** Reads the keypoint file of every frame, then fits. */
Result<std::vector<HandFit>> fitFingers(const BodyModel& body, const Scan& scan, BodyFit& fit);

}  // namespace dpl
