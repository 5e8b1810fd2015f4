// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Body fit: detector and time

/** Where a file names no unit, how many times as tall or short as the mean body a person may be for the unit to be taken for a metre.
 *  unit: ratio | origin: round figure; adults are 1.37 to 2.1 m tall, and worlds of unknown scale are mostly twice off or more | half,
 * double: half lets the mean body replace metres of tall and short people, double takes boxes of unit size for metres */
inline constexpr double kHumanSize = 1.25;
/** How well people know their own height.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kStatedHeightM = 0.01;
/** Standard deviation of a keypoint's coordinate at full confidence. The report states what the residuals of the scan show
 * (keypoint_noise.h). unit: share of the picture's diagonal | origin: dev; the noise that the generators add, 1.5 px at 378 × 504 | half,
 * double: 0.77 times, 600 draft steps: on procedural seed 1 keypoints 30.4 to 18.7 mm, static PSNR -0.16 dB, dynamic +0.46 dB; on
 * scan-tiny 25.7 to 27.2 mm, +0.02 dB, -0.20 dB */
inline constexpr double kKeypointSigma = 0.0024;
/** The same for keypoints that our networks found. Their errors follow the view: neighbouring frames share them, and in still frames shape
 * and offsets take up a part. unit: share of the picture's diagonal | origin: dev; training frames of scan-a and scan-c lie 4 to 6 px from
 * the truth at 378 × 504 | half, double: 0.0024 leaves joints of scan-a's moving training frames 49 instead of 37 mm from the truth (ankles
 * corrected by hand), double 41 instead of 42 mm */
inline constexpr double kFoundKeypointSigma = 0.006;
/** Geman-McClure scale of keypoint residuals.
 *  unit: standard deviations | origin: round figure | half, double: not measured */
inline constexpr double kKeypointOutlierSigmas = 4;
/** Distance between the place where a detector marks a keypoint and the body's keypoint of that name. Still frames show it; this only
 * bounds it where few do. unit: m | origin: round figure; a detector's pelvis lies 25 mm from ours | half, double: not measured */
inline constexpr double kLandmarkOffsetM = 0.03;
/** Turn of the root between still frames: people sway.
 *  unit: rad | origin: round figure | half, double: not measured */
inline constexpr double kSwayTurnRad = 0.01;
/** Shift of the root between still frames.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kSwayM = 0.01;
/** Slide of a standing foot between two moving frames, constant part.
 *  unit: m | origin: dev; scan-a and procedural seeds 1 to 3 | half, double: tighter flips an arm of procedural seed 3; 3.9 times, with the
 * tilt priors doubled: keypoints 6 to 18 % farther from the truth on four scans */
inline constexpr double kFootSlideM = 0.0008;
/** Slide of a standing foot between two moving frames, part that grows with the time between them.
 *  unit: m/s | origin: dev, with the value above | half, double: as above */
inline constexpr double kFootSlideMS = 0.002;
/** Geman-McClure scale of a foot's slide. A step is an outlier.
 *  unit: standard deviations | origin: round figure | half, double: not measured */
inline constexpr double kFootOutlierSigmas = 3;
/** Distance of the head's keypoints in three pictures in a row from a pose that moves evenly above which the head is taken to shake: root
 * mean square of a coordinate, by confidence.
 *  unit: standard deviations | origin: round figure; noise alone gives 1 | half, double: not measured */
inline constexpr double kShakenHeadSigmas = 1.5;
/** Angular acceleration of neck and head, each, while the head shakes or nods.
 *  unit: rad/s² | origin: round figure; 35° to both sides once or twice a second, in equal parts | half, double: not measured */
inline constexpr double kShakeRadS2 = 20;
/** Angular acceleration of the pelvis about the vertical.
 *  unit: rad/s² | origin: round figure | half, double: not measured */
inline constexpr double kTurnAccelerationRadS2 = 2.0;
/** Angular acceleration of the pelvis about other axes.
 *  unit: rad/s² | origin: dev; scan-a and procedural seeds 1 to 3 | half, double: double, with kTiltRad doubled and a foot slide of 3.9
 * times: keypoints 6 to 18 % farther from the truth on four scans */
inline constexpr double kTiltAccelerationRadS2 = 0.15;
/** Acceleration of the pelvis.
 *  unit: m/s² | origin: round figure | half, double: not measured */
inline constexpr double kRootAccelerationMS2 = 0.6;
/** Tilt of the pelvis against its still pose.
 *  unit: rad | origin: dev; scan-a and procedural seeds 1 to 3 | half, double: see kTiltAccelerationRadS2 */
inline constexpr double kTiltRad = 0.04;
/** Acceleration of an elbow or knee while depth choices are made.
 *  unit: m/s² | origin: round figure | half, double: not measured */
inline constexpr double kElbowAccelerationMS2 = 4;
/** Acceleration of a wrist or ankle while depth choices are made.
 *  unit: m/s² | origin: round figure | half, double: not measured */
inline constexpr double kWristAccelerationMS2 = 8;
/** Standard deviation of a candidate's depth, caused by keypoint noise.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kDepthNoiseM = 0.04;
/** A depth choice nearer than this to the current limb counts as unchanged.
 *  unit: m | origin: round figure, twice kDepthNoiseM | half, double: not measured */
inline constexpr double kSameLimbM = 0.08;

// ---- Body fit: silhouettes of clothed people

/** Distance by which the body sticks out of the mask.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kOutsideMaskM = 0.005;
/** Distance by which clothes stand off the body.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kClothesStandOffM = 0.04;
/** Geman-McClure scale of outline residuals: hair, bags, limbs in front of each other.
 *  unit: standard deviations | origin: round figure | half, double: not measured */
inline constexpr double kOutlineOutlierSigmas = 3;
/** The outline of one frame counts as this many independent residuals.
 *  unit: residuals | origin: round figure | half, double: not measured */
inline constexpr double kOutlineFrameWeight = 5;
/** Outline samples farther than this from the mask's edge are not matched to it.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kOutlineReachM = 0.08;
/** Stretch of a bone at morph value 1.
 *  unit: share of the bone's length | origin: round figure, about a standard deviation between adults of one height | half, double: not
 * measured */
inline constexpr float kBoneStretch = 0.04f;

}  // namespace dpl::priors
