// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/preset.h"

namespace dpl {

PresetSettings presetOf(Preset preset) {
    PresetSettings p{"standard", {}, 600, 80};
    p.training.init.splatCount = 60000;
    p.training.init.shDegree = 1;
    switch (preset) {
        case Preset::Draft:
            p.name = "draft";
            p.training.steps = 3000;
            p.training.init.splatCount = 40000;
            p.training.maxSplats = 50000;
            p.polishSteps = 200;
            p.poseFitSteps = 40;
            break;
        case Preset::Standard:
            p.training.steps = 10000;
            p.training.maxSplats = 80000;
            break;
        case Preset::High:
            p.name = "high";
            p.training.steps = 60000;
            p.training.init.splatCount = 120000;
            p.training.maxSplats = 300000;
            p.training.init.shDegree = 2;
            p.polishSteps = 2000;
            p.poseFitSteps = 120;
            break;
    }
    return p;
}

}  // namespace dpl
