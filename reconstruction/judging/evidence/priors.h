// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

namespace dpl::priors {

// ---- Evidence: what a part must gain

/** Gain below which an optional part of an avatar is left out of the file, whatever its size.
 *  unit: dB | origin: round figure, below what a change of seed does | half, double: not measured */
inline constexpr double kWorthItDb = 0.05;
/** Gain that a megabyte must bring on top: what `doppel pack` gives up for the last tenth of a file.
 *  unit: dB | origin: round figure | half, double: not measured */
inline constexpr double kWorthAMegabyteDb = 0.2;
/** Steps for which an avatar without a part is trained on before it is judged, as a share of the steps of the training.
 *  unit: ratio | origin: round figure; every picture is seen again twice | half, double: half of it
 *  overstates gains by 2 to 21 % on scan-a and scan-c-motion, and keeps the light of the scene in the latter (0.07 for 0.04 dB) */
inline constexpr double kRetrainShare = 0.08;

}  // namespace dpl::priors
