// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Light of the scene

/** Weight of a sighting of cloth or hair over one of skin. Cloth slips, so that a vertex shows other threads, and its folds turn normals.
 *  unit: ratio | origin: dev; scan-a and scan-c | half, double: by skin alone (0) errors of skin in moving pictures that were left out are
 * 1 to 7 % smaller than with 1 */
inline constexpr double kClothLightTrust = 0.1;
/** Change of the logarithm of brightness above which a sighting counts less: more is another texture or a shadow.
 *  unit: 1 | origin: round figure, a factor of 1.16 | half, double: not measured */
inline constexpr double kLightOutlier = 0.15;

}  // namespace dpl::priors
