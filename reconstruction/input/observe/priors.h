// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Masks that networks find

/** Mean of the network's masks above which a pixel is the person's: the network's outline lies outside it.
 *  unit: 0 to 1 | origin: dev; IoU at 0.50, 0.55, 0.60, training frames: 0.947, 0.950, 0.951 on scan-a, 0.949, 0.951, 0.951 on scan-c |
 * half, double: half takes a rim of background with it, double finds nobody */
inline constexpr double kMatteCut = 0.55;
/** How much less a close-up's found mask may agree with the hull of the full-body masks than the hull with itself.
 *  unit: IoU | origin: dev; right masks of scan-a and scan-c need up to 0.10, the least wrong one 0.14 | half, double: half replaces right
 * masks, double keeps masks that lack a sixth of the person */
inline constexpr double kCloseupSlack = 0.12;
/** Agreement of the hull with itself above which it can stand in for a close-up's mask. Below, a found mask needs as much support as if
 *  the hull agreed with itself so far.
 *  unit: IoU | origin: dev; above it the hull's IoU with true masks is 0.81 to 0.97, below 0.51 to 0.90 | half, double: half lets hulls of
 * swaying hands in, double never uses the hull */
inline constexpr double kHullCertainty = 0.8;

// ---- Landmarks: from the 33 points of the pose network to the 24 keypoints of a scan

/** Neck joint on the line from the shoulders' to the ears' middle.
 *  unit: share of the line | origin: dev; skeletons of the shared scans | half, double: not measured */
inline constexpr double kNeckShare = 0.44;
/** Toe joint on the line from heel to toe tip.
 *  unit: share of the line | origin: dev; skeletons of the shared scans | half, double: not measured */
inline constexpr double kToeShare = 0.72;
/** Head top beyond the ears' middle, where no mask shows it.
 *  unit: share of the line from the shoulders' to the ears' middle | origin: dev; skeletons of the shared scans | half, double: not
 * measured */
inline constexpr double kHeadTopShare = 0.55;
/** Distance by which the network marks hips below the hip joints.
 *  unit: trunk lengths | origin: dev; 12 of about 90 px on scan-a | half, double: not measured */
inline constexpr double kHipRaise = 0.12;
/** Distance by which the network marks shoulders above the shoulder joints.
 *  unit: trunk lengths | origin: dev; 6 of about 90 px on scan-a | half, double: not measured */
inline constexpr double kShoulderDrop = 0.06;
/** Distance by which the network marks knees below the knee joints.
 *  unit: thigh lengths, hip as the network marks it | origin: dev; still training frames: 0.08 on scan-a, 0.05 on scan-c, whose knees a
 * skirt hides | half, double: not measured */
inline constexpr double kKneeRaise = 0.06;
/** Confidence of a derived keypoint, relative to that of its sources.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kDerivedTrust = 0.7;

// ---- Hands: from the 21 points of the network of hands to those of a scan

/** Confidence of an arm's wrist above which its hand is looked for.
 *  unit: 0 to 1 | origin: round figure | half, double: not measured */
inline constexpr double kWristSeen = 0.3;
/** Side of the square in which an arm's hand is looked for first.
 *  unit: lengths of the palm | origin: dev; 74 visible hands of scan-a, marked with 4 px of noise: 2.0 and 2.6 find 55 | half, double: 1.6
 * finds 48, 5.2 finds 19 */
inline constexpr double kHandRoom = 2.3;
/** The same where nothing was found in that.
 *  unit: lengths of the palm | origin: round figure | half, double: not measured */
inline constexpr double kSecondHandRoom = 3.4;
/** Score of the network above which something is a hand.
 *  unit: 0 to 1 | origin: round figure | half, double: not measured */
inline constexpr double kHandConfirmed = 0.5;
/** Distance of a found hand from the arm's wrist above which it is somebody else's.
 *  unit: lengths of the hand | origin: round figure | half, double: not measured */
inline constexpr double kHandFromWrist = 0.4;
/** Distance between a point in the picture and in its mirror image that halves its confidence.
 *  unit: lengths of the hand | origin: round figure | half, double: not measured */
inline constexpr double kHandSpread = 0.1;

}  // namespace dpl::priors
