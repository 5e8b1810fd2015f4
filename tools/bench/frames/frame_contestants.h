// SPDX-License-Identifier: Apache-2.0
// Contestants that no user can choose: today's GPU frame with an optimisation switched off, by the options of the renderer inside the SDK,
// and the frozen plain frame (tools/bench/baseline).
#pragma once

#include "apps/bench/contestants.h"

namespace dpl {

/** Values of --renderers: those of `doppel bench` but for "vulkan", and those below. */
const std::vector<std::string>& frameRenderers();

/** vulkan-plain-float, vulkan-plain-tiles: the frozen frame with either fill.
 *  vulkan-without-culling, vulkan-float-keys, vulkan-two-frames: today's quads with one optimisation off. vulkan-tiles-all-off: today's
 * tiles with all three off. Everything else: sdkContestant. Unsupported also for vulkan-two-frames with one view. */
Result<Contestant> frameContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                   std::span<const Cameraf> views);

}  // namespace dpl
