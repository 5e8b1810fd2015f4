// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry. The ranges of single joints are rows of hand_rig.cpp, with their source.
#pragma once

namespace dpl::priors {

// ---- Fingers: what people do, and when keypoints count

/** Bend of a finger's joint against the pose that it is drawn to: the rest pose, and for moving frames the still pose.
 *  unit: rad | origin: round figure | half, double: 0.6 times, with half of kFingerGain: moving fingertips 15.3 instead of 14.1 mm from the
 * truth on procedural seed 2 */
inline constexpr double kFingerBendRad = 0.8;
/** The same for turns sideways, which the palm's bones leave little room for.
 *  unit: rad | origin: round figure | half, double: not measured */
inline constexpr double kFingerSpreadRad = 0.2;
/** The same for the joints of the thumb.
 *  unit: rad | origin: round figure | half, double: not measured */
inline constexpr double kThumbTurnRad = 0.5;
/** Bend of a finger's last joint as a share of that of its middle joint: one tendon bends both.
 *  unit: ratio | origin: Rijpkema and Girard, Computer animation of knowledge-based human grasping, 1991 | half, double: not measured */
inline constexpr double kEndBendShare = 2.0 / 3;
/** Difference of the last joint's bend from that share.
 *  unit: rad | origin: round figure | half, double: not measured */
inline constexpr double kEndBendRad = 0.26;
/** Angular acceleration of a finger's joint.
 *  unit: rad/s² | origin: round figure; a fist made in half a second accelerates at 28 | half, double: half, with half of kFingerGain:
 * moving fingertips 13.2 instead of 14.1 mm from the truth on procedural seed 2, whose gestures take a second */
inline constexpr double kFingerAccelerationRadS2 = 15;
/** Turn of the hand against the body fit's, which has one keypoint to tell it from.
 *  unit: rad | origin: round figure | half, double: half, with half of kFingerGain: still fingertips 5.1 instead of 4.4 mm from the truth
 * on procedural seed 2 */
inline constexpr double kWristTurnRad = 0.3;
/** Shift of the wrist against the body fit's.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr double kWristShiftM = 0.02;
/** Turn of a finger's joint against the pose that frames share, where they show one hand pose.
 *  unit: rad | origin: round figure; people who stand still keep their fingers within a few degrees | half, double: not measured */
inline constexpr double kSameHandRad = 0.1;
/** Length of a hand in the picture, wrist to middle fingertip of the rest pose, below which its fingers are not looked for.
 *  unit: px | origin: round figure | half, double: not measured */
inline constexpr double kSmallestHandPx = 24;
/** Mean confidence of a hand's points below which its fingers are not looked for.
 *  unit: 0 to 1 | origin: round figure; the sample marks hidden points with 0.46 and visible ones with 0.94 | half, double: not measured */
inline constexpr double kSureHand = 0.4;
/** Standard deviation of a coordinate of a point that our network of hands found, at full confidence.
 *  unit: lengths of the hand | origin: round figure; on procedural seed 2 a point lies 0.04 (close-ups) to 0.14 (below 30 px) off | half,
 * double: not measured */
inline constexpr double kFoundHandSigma = 0.05;
/** Fall of twice the negative log posterior that turned fingers must bring.
 *  unit: none | origin: procedural seed 2, 45 moving frames: fingertips 12.6 mm from the truth; noise alone brings 2 to 5 | half, double:
 * half 14.3 mm; 3.3 times, which is Akaike's 2 for each of 20 turns, leaves hands that bend by up to 46 degrees in the still pose */
inline constexpr double kFingerGain = 12;
/** Share of a hand's points farther than the outlier scale from the fitted fingers above which these are no hand of this person.
 *  unit: ratio | origin: round figure | half, double: not measured */
inline constexpr double kStrangeHand = 0.35;

}  // namespace dpl::priors
