// SPDX-License-Identifier: Apache-2.0
// Gain of the optimisations: compares the current frame with the frozen plain frame.
#pragma once

#include "apps/bench/contestants.h"

namespace dpl {

/** Two tables, one of whole frames and one of the passes that an optimisation affects, and the same figures as JSON lines. Each row gives
 *  the number of splats that either side draws. */
struct BenchWorth {
    bool compared = true;  // pictures were compared with the referee
    std::string frames, passes, json;

    void add(const BenchCase& test, const std::vector<Contestant>& list);
    std::string text() const;
};

}  // namespace dpl
