// SPDX-License-Identifier: Apache-2.0
// Gain of each optimisation: compares the current frame with the same frame with one or all optimisations off, and with the frozen plain
// frame.
#pragma once

#include "apps/bench/contestants.h"

namespace dpl {

/** Two tables, one of whole frames and one of the passes that an optimisation affects, and the same figures as JSON lines.
 *  Each row gives the number of splats that both sides draw, because the numbers differ: without culling the GPU also sorts and draws
 * splats that face away or are fainter than 1/255, which the frozen plain frame never draws. */
struct BenchWorth {
    bool compared = true;  // pictures were compared with the referee
    std::string frames, passes, json;

    void add(const BenchCase& test, const std::vector<Contestant>& list);
    std::string text() const;
};

}  // namespace dpl
