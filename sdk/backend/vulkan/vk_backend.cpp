// SPDX-License-Identifier: Apache-2.0
// How a backend begins and ends.
#include "sdk/backend/vulkan/vk_backend.h"

#include "sdk/backend/vulkan/vulkan_backend.h"

namespace dpl::vk {

VulkanBackend::VulkanBackend(std::unique_ptr<Device> device, ShaderPack pack)
    : SlottedBackend({"wait for the fence of that frame before, or call dplVulkanDropSlot if the commands will never run",
                      "call dplVulkanPrepare, or dplVulkanUpload in a frame without pictures,", "DplVulkanPass"}),
      device_(std::move(device)),
      vk_(device_->vk),
      pack_(std::move(pack)) {}

Status VulkanBackend::start() {
    VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    DPL_VK_MAKE(fence_, vk_.vkCreateFence(device_->device, &fence, device_->allocator, &fence_));
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device_->queueFamily;
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    DPL_VK_MAKE(uploadPool_, vk_.vkCreateCommandPool(device_->device, &pool, device_->allocator, &uploadPool_));
    VkCommandBufferAllocateInfo allocation{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocation.commandPool = uploadPool_;
    allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocation.commandBufferCount = 1;
    DPL_VK(vk_.vkAllocateCommandBuffers(device_->device, &allocation, &uploadCommands_));
    if (device_->lent) {
        DPL_RETURN_IF_ERROR(makeSubmissions());
        return makeLayerSlots();
    }
    DPL_VK_MAKE(copyFence_, vk_.vkCreateFence(device_->device, &fence, device_->allocator, &copyFence_));
    DPL_VK(vk_.vkAllocateCommandBuffers(device_->device, &allocation, &copyCommands_));
    return {};
}

VulkanBackend::~VulkanBackend() {
    for (auto& [id, frame] : frames_) (void)waitFor(frame);  // an app that lends its device waits for its own commands
    if (copyRuns()) (void)waitFor(copyFence_);
    retired_.forEach([&](Retirable& object) { free(object); });
    for (auto& [id, composer] : composers_) freeComposer(composer);
    for (auto& [id, target] : appTargets_) freeAppTarget(target);
    vk_.vkDestroyCommandPool(device_->device, submissionPool_, device_->allocator);
    freePipeline(composeLayout_);
    freeBuffer(marks_);
    vk_.vkDestroyDescriptorPool(device_->device, layerDescriptors_, device_->allocator);
    for (auto& [id, frame] : frames_) freeFrame(frame);
    for (auto& [id, target] : targets_) freeTarget(target);
    for (auto& [id, buffer] : buffers_) freeBuffer(buffer);
    for (Pipeline& pipeline : pipelines_) freePipeline(pipeline);
    for (auto& [key, pass] : renderPasses_) vk_.vkDestroyRenderPass(device_->device, pass, device_->allocator);
    vk_.vkDestroyCommandPool(device_->device, uploadPool_, device_->allocator);
    vk_.vkDestroyFence(device_->device, fence_, device_->allocator);
    vk_.vkDestroyFence(device_->device, copyFence_, device_->allocator);
}

namespace {

Result<std::unique_ptr<VulkanBackend>> startBackend(std::unique_ptr<Device> device, ShaderPack pack) {
    device->info.identity += formatText("-{}", pack.contentHash);
    auto backend = std::make_unique<VulkanBackend>(std::move(device), std::move(pack));
    DPL_RETURN_IF_ERROR(backend->start());
    return backend;
}

Result<ShaderPack> embeddedPack() {
    return readShaderPack(embeddedShaderPack(), "the embedded shader pack", embeddedShaderInterface());
}

}  // namespace

Result<std::unique_ptr<VulkanBackend>> createBackendOn(const AppDevice& app) {
    DPL_TRY(ShaderPack pack, embeddedPack());
    DPL_TRY(auto device, borrowDevice(app));
    return startBackend(std::move(device), std::move(pack));
}

Result<std::unique_ptr<Backend>> createBackend(const DeviceRequest& request, ShaderPack pack) {
    DPL_TRY(auto device, openDevice(request));
    DPL_TRY(auto backend, startBackend(std::move(device), std::move(pack)));
    return std::unique_ptr<Backend>(std::move(backend));
}

}  // namespace dpl::vk

namespace dpl {

Result<std::unique_ptr<Backend>> createVulkanBackend(const VulkanOptions& options) {
    DPL_TRY(ShaderPack pack, vk::embeddedPack());
    return vk::createBackend({.allowSoftware = options.allowSoftwareDevice}, std::move(pack));
}

}  // namespace dpl
