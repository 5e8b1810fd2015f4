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
    const Preset& preset = options.preset;
    s.training.steps = preset.steps;
    s.training.init.splatCount = preset.startSplats;
    s.training.maxSplats = preset.maxSplats;
    s.training.init.shDegree = preset.shDegree;
    s.polishSteps = preset.polishSteps;
    s.poseFit.iterations = preset.poseFitRounds;
    if (options.steps > 0)
        s = withTrainingSteps(s, options.steps);
    else
        s.timeBudgetMinutes = options.timeBudgetMinutes;
    s.checkpointS = options.checkpointS, s.from = options.from, s.device = options.device;
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
