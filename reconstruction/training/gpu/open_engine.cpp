// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/open_engine.h"

#include "reconstruction/training/gpu/self_test.h"
#include "reconstruction/training/gpu/vulkan_engine.h"

namespace dpl {

Result<std::unique_ptr<TrainingEngine>> openTrainingEngine(const EngineRequest& request) {
    vk::DeviceRequest wanted;
    wanted.allowSoftware = request.allowEmulated, wanted.name = request.name;
    DPL_TRY(auto engine, createVulkanEngine(wanted));
    DPL_RETURN_IF_ERROR(testEngine(*engine));
    return std::unique_ptr<TrainingEngine>(std::move(engine));
}

}  // namespace dpl
