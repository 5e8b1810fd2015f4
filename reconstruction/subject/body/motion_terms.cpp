// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/motion_terms.h"

#include "reconstruction/subject/body/fit_limbs.h"
#include "reconstruction/subject/body/priors.h"

namespace dpl {

void addMotionTerms(ceres::Problem& problem, const MotionModel& model, std::span<const MovingFrame> inTime) {
    const auto linked = [](double stepS) { return stepS > 1e-4 && !(stepS > kMaxGapS); };
    std::vector<size_t> feet;
    for (size_t k = 0; k < model.keypointNames.size(); ++k)
        for (const char* name : {"ankle_l", "ankle_r", "toe_l", "toe_r"})
            if (model.keypointNames[k] == name && model.context.chain->hasKeypoint(k)) feet.push_back(k);
    for (size_t i = 0; i + 1 < inTime.size() && !feet.empty(); ++i) {
        const MovingFrame &a = inTime[i], &b = inTime[i + 1];
        const double step = b.timeS - a.timeS;
        if (!linked(step) || (!a.free && !b.free)) continue;
        std::vector<double*> blocks = {model.shape};
        for (const MovingFrame* frame : {&a, &b}) {
            blocks.push_back(frame->root);
            addPoseBlocks(blocks, frame->pose, model.priors.size());
        }
        problem.AddResidualBlock(
            new FootRest(model.context, feet, *a.reference, *b.reference, priors::kFootSlideM + priors::kFootSlideMS * step), nullptr,
            blocks);
    }
    for (size_t i = 1; i + 1 < inTime.size(); ++i) {
        const MovingFrame &a = inTime[i - 1], &b = inTime[i], &c = inTime[i + 1];
        if (!linked(b.timeS - a.timeS) || !linked(c.timeS - b.timeS)) continue;
        if (!a.free && !b.free && !c.free) continue;
        for (size_t j = 0; j < model.priors.size(); ++j) {
            JointPrior prior = model.priors[j];
            if (prior.shakenRadS2 > 0 && (a.headShakes || b.headShakes || c.headShakes)) prior.accelerationRadS2 = prior.shakenRadS2;
            problem.AddResidualBlock(new JointSmoothness(prior, a.timeS, b.timeS, c.timeS, model.spread), nullptr, a.pose + 3 * j,
                                     b.pose + 3 * j, c.pose + 3 * j);
        }
        problem.AddResidualBlock(
            makeRootSmoothness({*a.reference, *b.reference, *c.reference}, model.up, a.timeS, b.timeS, c.timeS, model.spread), nullptr,
            a.root, b.root, c.root);
    }
}

}  // namespace dpl
