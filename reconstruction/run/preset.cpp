// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/preset.h"

#include <algorithm>

namespace dpl {
namespace {

void nameLabels(std::span<const ScanLabel> labels, InitSettings& init) {
    init.clothLabels.clear(), init.openLabels.clear();
    for (const ScanLabel& label : labels)
        if (label.name == "hair")
            init.openLabels.push_back(label.value);
        else if (label.name != "background" && label.name != "body" && label.name != "shoes")
            init.clothLabels.push_back(label.value);
}

}  // namespace

RunSettings settingsOf(const ReconstructOptions& options, std::span<const ScanLabel> labels) {
    RunSettings s;
    if (!labels.empty()) nameLabels(labels, s.training.init);
    s.training.seed = options.seed;
    switch (options.preset) {
        case Preset::Draft:
            s.training.steps = 3000;
            s.training.init.splatCount = 40000;
            s.training.maxSplats = 50000;
            s.polishSteps = 200;
            s.poseFit.iterations = 40;
            break;
        case Preset::Standard:
            s.training.steps = 10000;
            s.training.init.splatCount = 60000;
            s.training.maxSplats = 80000;
            s.polishSteps = 600;
            s.poseFit.iterations = 80;
            break;
        case Preset::High:
            s.training.steps = 60000;
            s.training.init.splatCount = 120000;
            s.training.maxSplats = 300000;
            s.training.init.shDegree = 2;
            s.polishSteps = 2000;
            s.poseFit.iterations = 120;
            break;
    }
    if (options.steps > 0)
        s = withTrainingSteps(s, options.steps);
    else
        s.timeBudgetMinutes = options.timeBudgetMinutes;
    s.checkpointS = options.checkpointS;
    s.layers = !options.without.layers;
    if (options.without.largeSteps) s.training.smoothingLengthM = 0;
    if (options.without.light) s.training.rateNodeLight = 0, s.training.learnLight = false;
    if (options.without.motion) s.training.learnMotion = false;
    if (options.without.gradientControl) s.training.closeupStepScale = 1;
    return s;
}

RunSettings withTrainingSteps(RunSettings settings, uint32_t steps) {
    settings.training.steps = steps;
    settings.polishSteps = std::min(settings.polishSteps, std::max(20u, steps / 10));
    return settings;
}

}  // namespace dpl
