// SPDX-License-Identifier: Apache-2.0
// What draft, standard and high mean.
#pragma once

#include "reconstruction/pipeline/reconstruct.h"
#include "reconstruction/splat/co_optimise.h"

namespace dpl {

struct PresetSettings {
    const char* name;
    CoOptimiseSettings training;
    uint32_t polishSteps;   // colour, opacity and size on the decoded bytes
    uint32_t poseFitSteps;  // per held-out frame
};

PresetSettings presetOf(Preset preset);

}  // namespace dpl
