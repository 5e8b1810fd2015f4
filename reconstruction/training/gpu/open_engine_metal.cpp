// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/metal_engine.h"
#include "reconstruction/training/gpu/open_engine.h"
#include "reconstruction/training/gpu/self_test.h"

namespace dpl {

Result<std::unique_ptr<TrainingEngine>> openTrainingEngine(const EngineRequest& request) {
    DPL_TRY(auto seam, mtl::openSeam());
    const std::string name = seam->name();
    if (name.find(request.name) == std::string::npos)
        return fail(Code::Unsupported, "no GPU is called '{}'; Metal gives {}", request.name, name);
    if (seam->isSoftware() && !request.allowEmulated) return fail(Code::Unsupported, "{} is played by the CPU", name);
    DPL_TRY(auto engine, createMetalEngine(std::move(seam)));
    DPL_RETURN_IF_ERROR(testEngine(*engine));
    return std::unique_ptr<TrainingEngine>(std::move(engine));
}

}  // namespace dpl
