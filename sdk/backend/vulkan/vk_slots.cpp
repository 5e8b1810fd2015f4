// SPDX-License-Identifier: Apache-2.0
// The slots of an app that lends its device: whether their commands have run, and what was destroyed while they may need it.
#include <algorithm>

#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {

uint32_t VulkanBackend::markOf(uint32_t slot) const {
    return reinterpret_cast<const volatile uint32_t*>(marks_.mapped)[slot];  // the GPU writes it
}

Status VulkanBackend::takeSlot(uint32_t slot) {
    if (slot >= kAppSlots) return fail(Code::InvalidArgument, "slot {} does not exist; there are {}", slot, kAppSlots);
    if (awaited_[slot] != 0 && markOf(slot) != awaited_[slot]) {
        DPL_RETURN_IF_ERROR(checkPresent());
        return fail(
            Code::InvalidArgument,
            "slot {} is prepared again, but the GPU has not run the commands that were prepared with it; wait for the fence of that "
            "frame before, or call dplVulkanDropSlot if the commands will never run",
            slot);
    }
    awaited_[slot] = 0;
    copies_.slotHasRun(slot);
    for (auto& [id, frame] : frames_)
        if (frame.run == FrameRun::Encoded && frame.running && frame.slot == slot) ended(frame);
    layerSlots_[slot].viewCount = 0;  // until setLayers(): if the new frame fails, nothing of the slot can be composed
    layerSlots_[slot].depths = depthsWritten();
    return {};
}

Status VulkanBackend::dropSlot(uint32_t slot) {
    if (slot >= kAppSlots) return fail(Code::InvalidArgument, "slot {} does not exist; there are {}", slot, kAppSlots);
    for (auto& [id, frame] : frames_)
        if (frame.run == FrameRun::Encoded && frame.slot == slot) {  // perhaps it never ran
            frame.running = frame.timed = false;
            frame.unread = VK_NULL_HANDLE;
        }
    copies_.slotIsDropped(slot);
    awaited_[slot] = 0;
    layerSlots_[slot].viewCount = 0;
    return {};
}

/** Frees an object once no commands of the app can need it: at once if no frame was encoded since it was created. */
template <class T>
void VulkanBackend::retire(T&& object, uint64_t born) {
    Retired& retired = retired_.emplace_back();
    retired.encoded = encoded_;
    retired.object = std::forward<T>(object);
    if (born < encoded_) return;
    free(retired);
    retired_.pop_back();
}
template void VulkanBackend::retire(Buffer&&, uint64_t);
template void VulkanBackend::retire(Target&&, uint64_t);
template void VulkanBackend::retire(Frame&&, uint64_t);
template void VulkanBackend::retire(VkPipeline&&, uint64_t);
template void VulkanBackend::retire(AppTarget&&, uint64_t);

/** Frees what no commands of the app can need any more. */
void VulkanBackend::freeRetired() {
    uint64_t oldest = encoded_;  // of the frames that may still run: the last one of each slot
    for (const uint64_t last : lastEncoded_)
        if (last > 0) oldest = std::min(oldest, last);
    while (!retired_.empty() && retired_.front().encoded < oldest) {
        free(retired_.front());
        retired_.erase(retired_.begin());
    }
}

void VulkanBackend::free(Retired& retired) {
    if (auto* buffer = std::get_if<Buffer>(&retired.object)) freeBuffer(*buffer);
    if (auto* target = std::get_if<Target>(&retired.object)) freeTarget(*target);
    if (auto* frame = std::get_if<Frame>(&retired.object)) freeFrame(*frame);
    if (auto* target = std::get_if<AppTarget>(&retired.object)) freeAppTarget(*target);
    if (auto* pipeline = std::get_if<VkPipeline>(&retired.object)) vk_.vkDestroyPipeline(device_->device, *pipeline, device_->allocator);
}

}  // namespace dpl::vk
