// SPDX-License-Identifier: Apache-2.0
// The model of docs/model.md for the contestants of a bench.
#pragma once

#include "apps/bench/contestants.h"
#include "tools/bench/frames/frame_model.h"

namespace dpl {

/** Rows for one case: the plain frame against today's by quads and by tiles, where those raced. Empty for general splats. */
std::string modelOf(const BenchCase& test, const std::vector<Contestant>& list, const BenchSubject& subject, bool corrected,
                    const ModelMachine& machine);

}  // namespace dpl
