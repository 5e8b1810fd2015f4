// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

#include <cstddef>

namespace dpl::priors {

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
/** Drop below the ears down to which long hair turns with the head alone.
 *  unit: m | origin: round figure; hair to the shoulders | half, double: not measured */
inline constexpr float kHairFollowsHeadM = 0.25f;
/** Drop below the ears from which on it follows the body below it: hair on the back does not swing out when its wearer looks down.
 *  unit: m | origin: round figure | half, double: not measured */
inline constexpr float kHairFollowsBodyM = 0.5f;
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

}  // namespace dpl::priors
