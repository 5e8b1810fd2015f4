// SPDX-License-Identifier: Apache-2.0
// What the optimisations are worth: the same frame with one of them off, with all of them off, and the frozen plain frame, against today's
// whole frame.
#pragma once

#include "apps/doppel/bench_contestants.h"

namespace dpl {

/** Two tables: whole frames, and each optimisation on the passes that it is for. */
struct BenchWorth {
    bool compared = true;  // with the referee
    std::string frames, passes;

    void add(const BenchCase& test, const std::vector<Contestant>& list);
    std::string text() const;
};

}  // namespace dpl
