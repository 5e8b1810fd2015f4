// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/open_engine.h"

namespace dpl {

Result<std::unique_ptr<TrainingEngine>> openTrainingEngine(const EngineRequest&) {
    return fail(Code::Unsupported, "this build of doppel has neither Vulkan nor Metal, so it trains on the CPU (--engine cpu)");
}

}  // namespace dpl
