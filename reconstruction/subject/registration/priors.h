// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

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

}  // namespace dpl::priors
