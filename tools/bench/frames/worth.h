// SPDX-License-Identifier: Apache-2.0
// What the optimisations are worth: today's whole frame against the same frame with one of them off, with all of them off, and against the
// frozen plain frame.
#pragma once

#include "apps/bench/contestants.h"

namespace dpl {

/** Two tables, whole frames and the passes that an optimisation is for; and the same as JSON lines.
 *  Each row says how many splats both sides draw: without culling the GPU sorts and draws also splats that are turned away or fainter than
 *  1/255, which the frozen plain frame never draws. */
struct BenchWorth {
    bool compared = true;  // with the referee
    std::string frames, passes, json;

    void add(const BenchCase& test, const std::vector<Contestant>& list);
    std::string text() const;
};

}  // namespace dpl
