// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Scan check: when a scan is refused or warned about

/** Sharpness of a frame, relative to the median of the training frames of its kind, below which the frame is left out.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kBlurredRelative = 0.25;
/** Median blur index of the training frames above which all pictures are soft and the scan is refused.
 *  unit: 0 to 1 | origin: dev; 0.25 to 0.30 on sharp scans, 0.61 after a blur of 4 px | half, double: half refuses some sharp scans;
 * double never refuses */
inline constexpr double kBlurredIndex = 0.58;
/** Share of the picture below which a mask is empty and its frame is left out.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kEmptyMaskShare = 0.002;
/** Share of the picture's edge above which a mask that touches it counts as cut off.
 *  unit: ratio | origin: round figure; a foot touches less, a cut waist more | half, double: not measured */
inline constexpr double kBorderShare = 0.01;
/** Jump of brightness between neighbouring still pictures that is worth a warning, after a fit by azimuth and height.
 *  unit: stops | origin: round figure | half, double: not measured */
inline constexpr double kExposureStops = 0.5;
/** Gap in the walk around the subject that is worth a warning.
 *  unit: degrees | origin: round figure; nine evenly spaced pictures | half, double: not measured */
inline constexpr double kGapWarnDeg = 40;
/** Gap in the walk around the subject that refuses the scan.
 *  unit: degrees | origin: round figure; nearly half of the subject is unseen | half, double: double never refuses */
inline constexpr double kGapRefuseDeg = 150;
/** Share of the masks that their common visual hull explains, below which there is a warning.
 *  unit: ratio | origin: dev; 0.99 on good scans, 0.68 to 0.95 at half or twice the focal length | half, double: half never warns before it
 * refuses */
inline constexpr double kCoherenceWarn = 0.96;
/** The same, below which the scan is refused.
 *  unit: ratio | origin: dev; 0.52 with shuffled cameras | half, double: half never refuses; double refuses every scan */
inline constexpr double kCoherenceRefuse = 0.6;
/** Median reprojection error of triangulated keypoints, as a share of the subject's height, above which there is a warning.
 *  unit: ratio | origin: dev; 0.007 on scan-a, 0.022 at half the focal length | half, double: double does not notice half the focal length
 */
inline constexpr double kKeypointWarn = 0.02;
/** The same, above which pictures are matched to see whether the cameras are right.
 *  unit: ratio | origin: dev; 0.007 on scan-a, whose cameras are exact | half, double: half matches the pictures of every scan, which takes
 * time; double misses cameras that are 3 px off */
inline constexpr double kCameraDoubt = 0.009;
/** The same, above which the scan is refused.
 *  unit: ratio | origin: dev; 0.068 with shuffled cameras | half, double: half refuses what is only worth a warning; double never refuses
 */
inline constexpr double kKeypointRefuse = 0.05;
/** Miss of a match of adjusted cameras far above which it counts little: wrong matches would move close-ups, which show little of the
 *  background.
 *  unit: of the picture's diagonal | origin: dev; with a coarser one close-ups of scan-a stay off by 1.46 px instead of 1.06 | half,
 * double: not measured
 */
inline constexpr double kAdjustedMatchMiss = 0.0005;
/** Miss of a match of adjusted cameras above which it does not count.
 *  unit: of the picture's diagonal | origin: dev; chosen with the former | half, double: not measured */
inline constexpr double kAdjustedMatchOutlier = 0.0016;
/** Error of the focal length, as the keypoints of still pictures tell it, above which there is a warning.
 *  unit: ratio | origin: dev; they tell it to 1 % on three scans, to 5 % without close-ups | half, double: half warns of good scans
 * without close-ups; double warns only where the scan is refused */
inline constexpr double kFocalWarn = 0.06;
/** The same, above which the scan is refused: the body would be as much too large or too small, and its limbs in wrong places.
 *  unit: ratio | origin: round figure | half, double: half refuses what is only worth a warning; double lets 20 % pass */
inline constexpr double kFocalRefuse = 0.12;
/** Miss of keypoints as given, relative to that at the best focal length, below which the pictures do not tell the focal length.
 *  unit: ratio | origin: dev; 1.3 to 1.4 at 20 % too short, 1.00 to 1.02 on good scans | half, double: not measured */
inline constexpr double kFocalMissRatio = 1.1;
/** Range of a joint's angle in the picture below which the joint counts as still.
 *  unit: degrees | origin: round figure | half, double: not measured */
inline constexpr double kPoseRangeDeg = 25;

// ---- Validation: training frames that decide and train nothing

/** Share of the moving training frames that is set aside. Data is scarce, so it is small.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kValidationMovingShare = 0.08;
/** Share of the still full-body training frames that is set aside.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kValidationStillShare = 0.05;
/** Share of the training close-ups that is set aside.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kValidationCloseupShare = 0.08;
/** With fewer training frames of a kind, none of them is set aside.
 *  unit: frames | origin: round figure | half, double: not measured */
inline constexpr double kMinFramesForValidation = 20;
/** Two cameras that look in directions nearer than this see the same side of the subject.
 *  unit: degrees | origin: round figure | half, double: not measured */
inline constexpr double kSameSideDeg = 30;

}  // namespace dpl::priors
