// SPDX-License-Identifier: Apache-2.0
// Priors: what reconstruction assumes about people, clothes, cameras and detectors, because it cannot be estimated from one scan. Each
// entry states meaning, unit, origin, and what half and double the value do. docs/reference/priors.md is generated from this file
// (tests/structure/check_priors.py --write).
//
// Origins. "round figure": chosen by judgement, to one or two digits. "dev": chosen on the development set, which
// reconstruction/report/provenance.cpp names. Figures of those scans are optimistic.
//
// In the body fit a length, angle or acceleration is the standard deviation of a term unless its text says otherwise. The spreads of single
// joints are not here: reconstruction/body/pose_prior.cpp holds them, a row a joint. Nor are the places where our networks mark joints:
// reconstruction/body/landmark_offsets.cpp holds them, a row a keypoint.
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
/** Miss of a match of adjusted cameras far above which it counts little: wrong matches would move close-ups, which show little of the
 *  background.
 *  unit: of the picture's diagonal | origin: dev; with a coarser one close-ups of scan-a stay off by 1.46 px instead of 1.06 | half,
 * double: not measured
 */
inline constexpr double kAdjustedMatchMiss = 0.0005;
/** Miss of a match of adjusted cameras above which it does not count.
 *  unit: of the picture's diagonal | origin: dev; chosen with the former | half, double: not measured */
inline constexpr double kAdjustedMatchOutlier = 0.0016;
/** The same, above which the scan is refused.
 *  unit: ratio | origin: dev; 0.068 with shuffled cameras | half, double: half refuses what is only worth a warning; double never refuses
 */
inline constexpr double kKeypointRefuse = 0.05;
/** Focal length of a phone's main camera, where nothing tells it; the search for cameras starts there.
 *  unit: diagonals of the picture | origin: round figure; 26 mm over the 43.3 mm of a 35 mm film | half, double: not measured; a start 14 %
 * too long ended at the right length */
inline constexpr double kPhoneFocal = 0.6;
/** Matches that agree beside a camera that is said to be near, below which all still pictures are searched too: posters repeat.
 *  unit: matches | origin: dev; videos of scan-a, where wrong ones had 26 to 36 and right ones 175 to 679 | half, double: half would still
 * tell them apart; double not measured */
inline constexpr size_t kSureMatches = 100;
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

// ---- Registration of moving frames to their pictures

/** Scale of the accelerations of joints and root, whose spread is Cauchy's: people mostly move evenly and sometimes start or stop.
 *  unit: share of the standard deviation in the body fit | origin: dev; scan-a and scan-c | half, double: not measured; the body fit's
 * Gaussian leaves keypoints 13.4 instead of 12.8 mm from the truth on scan-a */
inline constexpr double kAccelerationTailShare = 0.2;
/** Weight of a point's contrast against that of independent points with the noise below: light, cloth and surface err together.
 *  unit: ratio | origin: dev; scan-a and scan-c | half, double: 20 times: keypoints 20.9 instead of 14.3 mm from the truth on scan-a */
inline constexpr double kContrastTrust = 0.05;
/** The same for outlines.
 *  unit: ratio | origin: dev; scan-a and scan-c | half, double: not measured alone */
inline constexpr double kOutlineTrust = 0.05;
/** Weight of pictures beside keypoints that our networks found, relative to beside a scan's own. Found keypoints err alike from frame to
 *  frame, so their residuals claim more than they know.
 *  unit: ratio | origin: dev; moving training joints of scan-a, keypoints found, from 34.2 to 29.5 mm from the truth, of scan-c from 40.5
 * to 38.2 mm | half, double: half not measured; double: 28.8 mm on scan-a, but held-out ones 44.2 instead of 42.7 mm */
inline constexpr double kFoundPictureWeight = 3;
/** Distance of a limb's found keypoint from the pose above which its other depths are tried.
 *  unit: standard deviations | origin: dev; scan-a, keypoints found: held-out moving joints 32.0 mm from the truth, without the search 42.7
 * mm | half, double: not measured at the blur of the search; at 4 px 3 leaves moving training joints 28.5 instead of 28.3 mm */
inline constexpr double kLimbDoubtSigmas = 1.7;
/** Distance from the shaped body up to which skin, hair and shoes count as rigid.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr float kRigidStandOffM = 0.05f;
/** The same where nothing is known about clothes.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr float kTightStandOffM = 0.01f;
/** Distance that a point of skin, hair or shoes lies from where the rig carries it.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kRigidSlipM = 0.003;
/** The same for cloth.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kClothSlipM = 0.015;
/** Distance of a drawn outline of skin, hair or shoes from that in the picture.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kRigidOutlineM = 0.004;
/** The same for cloth.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kClothOutlineM = 0.02;
/** Difference of local contrast between pictures of one point that light and camera make.
 *  unit: share of white | origin: round figure | half, double: not measured */
inline constexpr double kContrastNoise = 0.02;
/** Geman-McClure scale of contrast residuals: shadows, things in front.
 *  unit: standard deviations | origin: round figure | half, double: not measured */
inline constexpr double kContrastOutlierSigmas = 3;

// ---- Surface and training

/** Smoothing length of surface offsets in the first level of the silhouette fit.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kStartSmoothingM = 0.12;
/** The same in the last level.
 *  unit: m | origin: dev; scan-a | half, double: 2.5 times (30 mm) lowers the mean IoU on scan-a from 0.962 to 0.940 */
inline constexpr double kEndSmoothingM = 0.012;
/** Longest offset from the body: long enough for a helmet in the hand, too short for a wall.
 *  unit: m | origin: dev; the biker holds a helmet | half, double: not measured */
inline constexpr double kMaxOffsetM = 0.35;
/** Longest translation of one still view while the surface is fitted: the subject sways between pictures.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kMaxViewSwayM = 0.03;
/** Share that is kept of a pull's part along the outline. Most of it is noise, but the far side of a held object needs it.
 *  unit: ratio | origin: dev; the biker's helmet | half, double: not measured */
inline constexpr double kTangentShare = 0.25;
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
/** Distance between the control nodes of pose correctives: about a fold of cloth.
 *  unit: m | origin: dev; scan-a | half, double: 0.045 loses 0.3 dB on scan-a, 0.02 gains 0.05 dB */
inline constexpr double kNodeSpacingM = 0.03;
/** Gain below which an optional part of an avatar is left out of the file, whatever its size.
 *  unit: dB | origin: round figure, below what a change of seed does | half, double: not measured */
inline constexpr double kWorthItDb = 0.05;
/** Gain that a megabyte must bring on top: what `doppel pack` gives up for the last tenth of a file.
 *  unit: dB | origin: round figure | half, double: not measured */
inline constexpr double kWorthAMegabyteDb = 0.2;
/** Steps for which an avatar without a part is trained on before it is judged, as a share of the steps of the training.
 *  unit: ratio | origin: round figure; every picture is seen again twice | half, double: not measured */
inline constexpr double kRetrainShare = 0.08;

// ---- Garments

/** Share of the views that may say "outside" at a point of the silhouettes' hull: masks and sway err.
 *  unit: ratio | origin: dev; scan-c | half, double: not measured */
inline constexpr double kHullOutvotedShare = 0.04;
/** Still pictures below which garments are not cut from the hull of the masks, because it bulges between the views.
 *  unit: pictures | origin: dev; on scan-tiny, which has 15, layers lower the held-out alpha IoU of still frames from 0.965 to 0.943 |
 * half, double: half makes layers on scan-tiny; double not measured */
inline constexpr size_t kFewestHullViews = 20;
/** Pixels of skin or background between the legs, in all moving pictures together, below which a garment stays as the hull has it.
 *  unit: pixels | origin: round figure; the smallest of three right ones, procedural seed 1, has 27 | half, double: not measured */
inline constexpr size_t kFewestFreePixels = 10;
/** How many of those there must be for each pixel of cloth, to show trousers and not a skirt.
 *  unit: ratio | origin: dev; free and cloth are 27 and 3 on procedural seed 1, 57 and 6 on scan-a, 62 and 298 on seed 1 in a skirt, 0 and
 * 2778 on scan-c's skirt | half, double: neither changes a decision there */
inline constexpr size_t kFreePerCloth = 2;
/** Distance from the body within which cloth follows the body's skin weights.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kClothContactM = 0.015;
/** Length over which the skin weights of free-hanging cloth are smoothed, for each metre of distance from the body.
 *  unit: ratio | origin: dev; scan-c | half, double: not measured */
inline constexpr double kClothHang = 3;
/** Depth of the body below clothes.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kBodyBelowClothM = 0.004;
/** Distance above the skin below which training pushes a garment outwards.
 *  unit: m | origin: round figure; half of the value above | half, double: not measured */
inline constexpr float kClothClearanceM = 0.002f;
/** How far skin that no picture shows is taken in where clothes sink into it.
 *  unit: m | origin: dev; one walk on scan-a and scan-c | half, double: in place of 0.87 and 0.86 % of the garments' vertices 1.02 and 1.12
 * % lie inside; at one and a half times 0.81 and 0.61 % */
inline constexpr float kTuckM = 0.01f;
/** What the frames must show of a triangle, in shares of its area, for its splats to learn; relative to the median triangle.
 *  unit: ratio | origin: dev; pictures of a walk of scan-a and scan-c | half, double: a quarter leaves shreds at the armpits of scan-a;
 * double not measured */
inline constexpr float kSeenShare = 0.04f;

}  // namespace dpl::priors
