// SPDX-License-Identifier: Apache-2.0
// Which pictures of a walk round a subject are matched, before anything is known about their cameras.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace dpl {

/** Pairs (first < second) of `stills` pictures in the order of the walk, followed by `closeups` close-ups. Each still is matched with its
 *  three next neighbours, the last with the first, and with nine stills spread over the walk: these close loops and join walks at several
 *  heights. Each close-up is matched with its three next neighbours and with up to 20 stills spread over the walk. Grows with the number of
 *  pictures, where all pairs would grow with its square. */
std::vector<std::pair<size_t, size_t>> pairsToMatch(size_t stills, size_t closeups);

}  // namespace dpl
