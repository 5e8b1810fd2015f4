// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Surface

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
/** Weight of a mark in one picture, such as an eye, against a point of its outline. Outlines alone slide the face along below the hair.
 *  unit: points | origin: dev; the face of procedural seed 1 lies 17.5 mm from where it should without marks, 12.2, 9.9, 8.2 and 6.8 mm at
 * 10, 30, 100 and 300; its eyes 27.5, 7.9, 5.6, 4.5 and 4.5 mm, at the same IoU | half, double: by the table */
inline constexpr double kMarkWeight = 100;
/** Distance of a mark from the surface's own point at which it counts a quarter: farther ones are mistakes of whoever marked it.
 *  unit: m | origin: round figure, a little more than kLandmarkOffsetM | half, double: not measured */
inline constexpr double kMarkReachM = 0.04;

}  // namespace dpl::priors
