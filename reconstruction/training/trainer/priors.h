// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Edges of masks

/** Distance from the edge of a mask that our networks found within which a pixel may be on the wrong side.
 *  unit: share of the picture's diagonal | origin: dev; 5 px at 378 × 504 on scan-a | half, double: 3 px lower scan-a's validation
 * pictures from 20.38 to 20.32 dB still and from 18.68 to 18.59 dB moving, 2 px by a further 0.04 and 0.02; double not measured */
inline constexpr double kFoundMaskEdge = 0.0075;
/** Weight of the mask loss in the pixels of the edge of a mask that the scan brings, where person and background mix: the picture alone
 *  would thin the edge.
 *  unit: ratio to the weight elsewhere | origin: dev; scan-a's validation pictures 24.97 dB still and 21.04 moving without this edge, 25.43
 * and 21.25 at 4, 25.51 and 21.30 at 8 | half, double: half on procedural seed 1, 21.80 instead of 22.18 dB still and 19.44 instead
 * of 19.37 moving; 1 there 21.48 and 19.15; double not measured */
inline constexpr double kGivenMaskEdgeWeight = 6;

// ---- Training and pose fit

/** Smoothing length of the static offsets in training (LargeSteps).
 *  unit: m | origin: dev; still validation frames of scan-a and scan-c | half, double: half gains 0.1 dB on still and 0.03 dB on moving
 * frames of scan-c, 4 times loses 0.2 and 0.1 dB on both scans; the length is our form of the λ of Nicolet et al. 2021, Large Steps in
 * Inverse Rendering */
inline constexpr double kTrainingSmoothingM = 0.01;
/** Independent residuals that a pixel of the person counts as, when training weighs a picture against the registered pose.
 *  unit: ratio | origin: dev; validation frames of scan-a and scan-c | half, double: keypoints after the pose fit, which had the same trust
 * then, at 0.2, 0.4, 1 and 4 times this 11.9, 12.5, 12.8, 13.7 mm on scan-a (12.6 registered) and 13.8, 13.7, 13.4, 13.4 mm on scan-c (15.5
 * registered) */
inline constexpr double kTrainedPictureTrust = 0.05;
/** The same in the pose fit of a finished avatar. A wrong pose no longer teaches the avatar, so a picture deserves more trust.
 *  unit: ratio | origin: dev; validation frames of scan-a and scan-c | half, double: a tenth (kFittedDepthTrust times 3) loses 0.16 and
 * 0.38 dB on moving validation frames, three times (kFittedDepthTrust times 0.3) gains 0.02 and 0.09 dB; keypoints at a tenth, once and
 * three times 11.3, 11.5, 11.9 mm on scan-a and 14.2, 13.2, 12.3 mm on scan-c */
inline constexpr double kFittedPictureTrust = 0.5;
/** The same in the pose fit for the distance of the person from the camera. A picture tells it through the person's size alone. The
 *  avatar's own size is wrong by some thousandths, and 3 of them are 6.6 mm at 2.2 m.
 *  unit: ratio | origin: dev; validation frames of scan-a and scan-c | half, double: with kFittedPictureTrust in its place keypoints of
 * moving validation frames are 12.6 instead of 11.5 mm off on scan-a and 13.0 instead of 13.2 on scan-c, for 0.02 and 0.08 dB more */
inline constexpr double kFittedDepthTrust = 0.5 / 30;

// ---- Motion modes

/** By how much the offsets of neighbouring nodes may differ in the column that says that the subject has moved, over their distance.
 *  unit: ratio | origin: dev; walks and moving frames of scan-c | half, double: half not measured; double, with kComponentStrain doubled,
 * gains 0.17 dB on moving frames and leaves lumps in a skirt that walks, whose longest edge grows from 2.6 to 2.9 times its length */
inline constexpr float kMovedStrain = 0.15f;
/** The same in a component of unit variance.
 *  unit: ratio | origin: dev; walks and moving frames of scan-c | half, double: half not measured; double with kMovedStrain */
inline constexpr float kComponentStrain = 0.06f;
/** The same in a component of held peaks, which adds to that of the pose.
 *  unit: ratio | origin: dev; walks and moving frames of scan-c | half, double: half not measured; double gains 0.03 dB on
 * moving frames with pose fit and none without, and lengthens the longest edge of walks from 2.5 and 3.3 to 2.9 and 3.5 times */
inline constexpr float kPeakStrain = 0.03f;

// ---- Backs that show

/** What the frames must show of a triangle, in shares of its area, for its splats to learn; relative to the median triangle.
 *  unit: ratio | origin: dev; pictures of a walk of scan-a and scan-c | half, double: a quarter leaves shreds at the armpits of scan-a;
 * double not measured */
inline constexpr float kSeenShare = 0.04f;

}  // namespace dpl::priors
