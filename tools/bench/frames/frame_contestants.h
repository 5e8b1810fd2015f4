// SPDX-License-Identifier: Apache-2.0
// Contestants that users cannot choose: the frozen plain frame (tools/bench/baseline).
#pragma once

#include "apps/bench/contestants.h"

namespace dpl {

/** Values of --renderers: those of `doppel bench` except "vulkan", and those of frameContestant below. */
const std::vector<std::string>& frameRenderers();

/** vulkan-plain-float, vulkan-plain-tiles: the frozen frame, filled by quads or by tiles. Any other name goes to sdkContestant. Returns
 *  Unsupported if the machine cannot run it. */
Result<Contestant> frameContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                   std::span<const Cameraf> views);

}  // namespace dpl
