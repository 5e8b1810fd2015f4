// SPDX-License-Identifier: Apache-2.0
// Priors of this room: what it assumes because it cannot be estimated from one scan. docs/reference/priors.md, generated from all of them,
// explains the fields of an entry.
#pragma once

#include <cstddef>

namespace dpl::priors {

// ---- Search for cameras

/** Focal length of a phone's main camera, where nothing tells it; the search for cameras starts there.
 *  unit: diagonals of the picture | origin: round figure; 26 mm over the 43.3 mm of a 35 mm film | half, double: not measured; a start 14 %
 * too long ended at the right length */
inline constexpr double kPhoneFocal = 0.6;
/** Matches that agree beside a camera that is said to be near, below which all still pictures are searched too: posters repeat.
 *  unit: matches | origin: dev; videos of scan-a, where wrong ones had 26 to 36 and right ones 175 to 679 | half, double: half would still
 * tell them apart; double not measured */
inline constexpr size_t kSureMatches = 100;

}  // namespace dpl::priors
