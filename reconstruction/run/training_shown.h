// SPDX-License-Identifier: Apache-2.0
// Shows a training to those who watch the run (run_news.h). It changes nothing of the training.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/run_news.h"
#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

class TrainingShown {
public:
    /** Keeps skeleton and mesh of the input. news: null: shows nothing; must outlive this. */
    TrainingShown(RunNews* news, const CoOptimiseInput& input);

    /** Shows the middle one of the validation frames, of whole bodies if there are any. Test frames are for the report alone. */
    void heldBack(const FrameTable& table);
    /** Shows the curve, and the avatar so far where it is time. steps: of the whole training. */
    void after(const CoOptimiser& optimiser, uint32_t steps);

private:
    RunNews* news_;
    AvatarData avatar_;  // without splats
};

}  // namespace dpl
