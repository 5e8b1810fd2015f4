// SPDX-License-Identifier: Apache-2.0
// Table rows of the frame model (docs/model.md) for the contestants of a bench.
#pragma once

#include "apps/bench/contestants.h"
#include "apps/reference/reference_file.h"
#include "tools/bench/frames/frame_model.h"

namespace dpl {

/** Rows for one case: the plain frame against the current frame by quads and by tiles, if those took part. Empty for general splats. */
std::string modelOf(const BenchCase& test, const std::vector<Contestant>& list, const BenchSubject& subject, const ReferenceFile& referee,
                    const ModelMachine& machine);

}  // namespace dpl
