// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Pose correctives

/** Distance between the control nodes of pose correctives: about a fold of cloth.
 *  unit: m | origin: dev; scan-a | half, double: 0.045 loses 0.3 dB on scan-a, 0.02 gains 0.05 dB */
inline constexpr double kNodeSpacingM = 0.03;

}  // namespace dpl::priors
