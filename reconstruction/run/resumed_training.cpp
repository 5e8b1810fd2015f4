// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/resumed_training.h"

#include <chrono>

namespace dpl {

Status trainFromCheckpoint(CoOptimiser& trainer, const std::filesystem::path& checkpoint, double everyS, Progress& progress,
                           const std::function<void()>& after) {
    if (std::filesystem::exists(checkpoint)) {
        if (Status restored = trainer.restore(checkpoint); restored)
            progress.note(formatText("continuing at step {}", trainer.step()));
        else
            progress.note(formatText("starting over: {}", restored.error().message));
    }
    auto saved = std::chrono::steady_clock::now();
    while (!trainer.finished()) {
        const Status ran = trainer.run(100);
        const bool due = std::chrono::duration<double>(std::chrono::steady_clock::now() - saved).count() > everyS;
        if (due || !ran) {
            DPL_RETURN_IF_ERROR(trainer.checkpoint(checkpoint));
            saved = std::chrono::steady_clock::now();
        }
        DPL_RETURN_IF_ERROR(ran);
        if (after) after();
    }
    return {};
}

}  // namespace dpl
