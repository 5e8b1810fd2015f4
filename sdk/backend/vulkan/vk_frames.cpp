// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "sdk/backend/hazards.h"
#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {
namespace {

constexpr uint64_t kFrameTimeoutNs = 120ull * 1000 * 1000 * 1000;  // enough for a slow software device; then a hung device is an error

constexpr VkPipelineStageFlags kGpuStages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT |
                                            VK_PIPELINE_STAGE_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
constexpr VkPipelineStageFlags kReaders = kGpuStages | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;  // of a frame, and passes of an app

}  // namespace

/** Writes the steps of a frame into a command buffer. Allocates nothing, but for read-backs of targets that must be rounded. */
struct VulkanBackend::Recorder {
    VulkanBackend& backend;
    VkCommandBuffer commands;
    VkDescriptorSet descriptors = VK_NULL_HANDLE;  // of the step
    const Functions& vk = backend.vk_;

    void barrier(VkPipelineStageFlags before = kGpuStages, VkPipelineStageFlags after = kGpuStages) {
        VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
        memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                               VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
        vk.vkCmdPipelineBarrier(commands, before, after, 0, 1, &memory, 0, nullptr, 0, nullptr);
    }

    void bind(VkPipelineBindPoint point, const Pipeline& pipeline, const PushBytes& push) {
        vk.vkCmdBindPipeline(commands, point, pipeline.pipeline);
        vk.vkCmdBindDescriptorSets(commands, point, pipeline.layout, 0, 1, &descriptors, 0, nullptr);
        if (push.size) vk.vkCmdPushConstants(commands, pipeline.layout, pipeline.stages, 0, push.size, push.bytes.data());
    }

    Status operator()(const FillStep& step) {
        vk.vkCmdFillBuffer(commands, backend.buffers_.at(step.buffer.value).buffer, 0, VK_WHOLE_SIZE, step.value);
        return {};
    }

    Status operator()(const ComputeStep& step) {
        bind(VK_PIPELINE_BIND_POINT_COMPUTE, backend.pipelines_[step.pipeline.value - 1], step.push);
        if (step.indirect.buffer) {
            vk.vkCmdDispatchIndirect(commands, backend.buffers_.at(step.indirect.buffer.value).buffer, step.indirect.offset);
        } else {
            vk.vkCmdDispatch(commands, step.groups, 1, 1);
        }
        return {};
    }

    Status operator()(const DrawStep& step) {
        const Target& target = backend.targets_.at(step.target.value);
        VkClearValue clear[2]{};
        clear[0].color.float32[3] = 1;  // nothing drawn: black, transmittance 1, no depth
        VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        DPL_TRY(begin.renderPass, backend.renderPass(target.desc));
        begin.framebuffer = target.surfaces[target.desc.multiview ? 0 : step.view].framebuffer;
        begin.renderArea.extent = target.extent;
        begin.clearValueCount = target.desc.depth ? 2 : 1;
        begin.pClearValues = clear;
        vk.vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        const VkViewport viewport{0, 0, float(target.extent.width), float(target.extent.height), 0, 1};
        const VkRect2D scissor{{0, 0}, target.extent};
        vk.vkCmdSetViewport(commands, 0, 1, &viewport);
        vk.vkCmdSetScissor(commands, 0, 1, &scissor);
        bind(VK_PIPELINE_BIND_POINT_GRAPHICS, backend.pipelines_[step.pipeline.value - 1], step.push);
        vk.vkCmdDrawIndirect(commands, backend.buffers_.at(step.args.buffer.value).buffer, step.args.offset, 1, 16);
        vk.vkCmdEndRenderPass(commands);
        return {};
    }

    Status operator()(const ReadbackStep& step) {
        const Target& target = backend.targets_.at(step.target.value);
        roundColour(target);
        for (uint32_t v = 0; v < target.desc.views; ++v) {
            const Surface& surface = target.surfaces[target.desc.multiview ? 0 : v];
            copy(target, v, surface.rounded, step.colour, 4);
            if (step.depth) copy(target, v, surface.depth, step.depth, backend.device_->info.halfDepth ? 4 : 8);
        }
        hostBarrier();
        return {};
    }

    Status operator()(const CopyStep& step) {
        const Buffer &from = backend.buffers_.at(step.from.value), &to = backend.buffers_.at(step.to.value);
        const bool back = to.desc.memory == BufferMemory::Readback;
        const VkBufferCopy region{back ? step.offset : 0, back ? 0 : step.offset, back ? to.desc.bytes : from.desc.bytes};
        vk.vkCmdCopyBuffer(commands, from.buffer, to.buffer, 1, &region);
        if (back) hostBarrier();
        return {};
    }

    void hostBarrier() {
        VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        memory.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        memory.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vk.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0,
                                nullptr);
    }

    /** Gives an image that nothing draws or reads the layout that its descriptor promises. */
    void makeReadable(const Image& image) {
        VkImageMemoryBarrier change{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
        change.image = image.image;
        change.srcQueueFamilyIndex = change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        change.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
        change.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
        change.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        vk.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, 0, 0, nullptr, 0,
                                nullptr, 1, &change);
    }

    /** Copies f16 colour into the RGBA8 image by a blit, which converts and rounds. */
    void roundColour(const Target& target) {
        const uint32_t layers = target.desc.multiview ? target.desc.views : 1;
        std::vector<VkImageMemoryBarrier> images(target.surfaces.size(), VkImageMemoryBarrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER});
        const auto barrier = [&] {
            vk.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0, nullptr,
                                    uint32_t(images.size()), images.data());
        };
        for (size_t i = 0; i < images.size(); ++i) {
            VkImageMemoryBarrier& image = images[i];
            image.image = target.surfaces[i].rounded.image;
            image.srcQueueFamilyIndex = image.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
            image.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, layers};
            image.srcAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
            image.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
            image.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
        }
        barrier();
        VkImageBlit blit{};
        blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, layers};
        blit.srcOffsets[1] = blit.dstOffsets[1] = {int32_t(target.extent.width), int32_t(target.extent.height), 1};
        for (const Surface& surface : target.surfaces)
            vk.vkCmdBlitImage(commands, surface.colour.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, surface.rounded.image,
                              VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
        for (VkImageMemoryBarrier& image : images) {
            image.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
            image.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
            image.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
            image.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        }
        barrier();
    }

    void copy(const Target& target, uint32_t view, const Image& image, BufferId to, uint64_t pixelBytes) {
        VkBufferImageCopy region{};
        region.bufferOffset = uint64_t(view) * target.desc.widthPx * target.desc.heightPx * pixelBytes;
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, target.desc.multiview ? view : 0, 1};
        region.imageExtent = {target.desc.widthPx, target.desc.heightPx, 1};
        vk.vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, backend.buffers_.at(to.value).buffer, 1,
                                  &region);
    }
};

Status VulkanBackend::makeDescriptorPool(Frame& frame, std::span<const Step> steps) {
    uint32_t sets = 0, uniforms = 0, storages = 0;  // texel buffers are counted with the storage buffers
    const auto count = [&](const std::vector<Binding>& bindings) {
        ++sets;
        for (const Binding& b : bindings) ++(b.access == Access::Uniform ? uniforms : storages);
    };
    for (const Step& step : steps) {
        if (const auto* compute = std::get_if<ComputeStep>(&step)) count(compute->bindings);
        if (const auto* draw = std::get_if<DrawStep>(&step)) count(draw->bindings);
    }
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, uniforms + 1},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, storages + 1},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, storages + 1}};
    VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    info.maxSets = sets + 1;
    info.poolSizeCount = 3;
    info.pPoolSizes = sizes;
    DPL_VK_MAKE(frame.descriptors, vk_.vkCreateDescriptorPool(device_->device, &info, device_->allocator, &frame.descriptors));
    return {};
}

Result<VkDescriptorSet> VulkanBackend::descriptorSet(const Frame& frame, const Pipeline& pipeline, const std::vector<Binding>& bindings) {
    VkDescriptorSetAllocateInfo allocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocation.descriptorPool = frame.descriptors;
    allocation.descriptorSetCount = 1;
    allocation.pSetLayouts = &pipeline.setLayout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    DPL_VK(vk_.vkAllocateDescriptorSets(device_->device, &allocation, &set));
    std::vector<VkDescriptorBufferInfo> infos(bindings.size());
    std::vector<VkBufferView> views(bindings.size());
    std::vector<VkWriteDescriptorSet> writes;
    for (size_t i = 0; i < bindings.size(); ++i) {
        Buffer& b = buffers_.at(bindings[i].buffer.value);
        const size_t own = pipeline.shader->bindings.size();
        const ShaderBinding& want = i < own ? pipeline.shader->bindings[i] : pipeline.fragment->bindings[i - own];
        if (b.desc.memory == BufferMemory::Lent) continue;  // lend() binds it
        infos[i] = {b.buffer, 0, b.desc.bytes};
        VkWriteDescriptorSet& write = writes.emplace_back(VkWriteDescriptorSet{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET});
        write.dstSet = set;
        write.dstBinding = uint32_t(i);
        write.descriptorCount = 1;
        write.descriptorType = descriptorType(want);
        write.pBufferInfo = &infos[i];
        if (want.texelWords) {
            DPL_TRY(views[i], texels(b, want.texelWords));
        }
        write.pTexelBufferView = &views[i];
    }
    vk_.vkUpdateDescriptorSets(device_->device, uint32_t(writes.size()), writes.data(), 0, nullptr);
    return set;
}

/** Prepares descriptors, barriers and timestamps of the steps. */
Status VulkanBackend::prepare(Frame& frame, std::vector<Step> steps) {
    DPL_RETURN_IF_ERROR(makeDescriptorPool(frame, steps));
    Hazards hazards;
    frame.steps.reserve(steps.size());
    for (Step& step : steps) {
        RecordedStep recorded;
        recorded.barrier = std::visit([&](const auto& s) { return hazards.before(s); }, step);
        if (const auto* compute = std::get_if<ComputeStep>(&step)) {
            DPL_TRY(recorded.descriptors, descriptorSet(frame, pipelines_[compute->pipeline.value - 1], compute->bindings));
        }
        if (const auto* draw = std::get_if<DrawStep>(&step)) {
            DPL_TRY(recorded.descriptors, descriptorSet(frame, pipelines_[draw->pipeline.value - 1], draw->bindings));
        }
        frame.labels.push_back(stepLabel(step));
        recorded.step = std::move(step);
        frame.steps.push_back(std::move(recorded));
    }
    if (device_->info.timestamps) {
        VkQueryPoolCreateInfo query{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
        query.queryType = VK_QUERY_TYPE_TIMESTAMP;
        query.queryCount = uint32_t(steps.size()) + 1;
        for (size_t i = 0; i < (frame.run == FrameRun::Encoded ? 2 : 1); ++i)
            DPL_VK_MAKE(frame.timestamps[i], vk_.vkCreateQueryPool(device_->device, &query, device_->allocator, &frame.timestamps[i]));
        frame.ticks.resize(query.queryCount);
    }
    return {};
}

/** Writes the prepared steps into a command buffer. Allocates nothing in frames without read-backs. */
Status VulkanBackend::play(const Frame& frame, VkCommandBuffer commands) {
    Recorder recorder{*this, commands};
    const VkQueryPool timestamps = frame.timestamps[frame.nextTimestamps];
    const auto stamp = [&](uint32_t index) {
        if (timestamps) vk_.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps, index);
    };
    if (timestamps) vk_.vkCmdResetQueryPool(commands, timestamps, 0, uint32_t(frame.ticks.size()));
    stamp(0);
    for (size_t i = 0; i < frame.steps.size(); ++i) {
        const RecordedStep& recorded = frame.steps[i];
        if (recorded.barrier) recorder.barrier();
        recorder.descriptors = recorded.descriptors;
        DPL_RETURN_IF_ERROR(std::visit(recorder, recorded.step));
        stamp(uint32_t(i) + 1);
    }
    return {};
}

/** Records a submitted frame into a command buffer of its own. */
Status VulkanBackend::record(Frame& frame) {
    VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    DPL_VK_MAKE(frame.fence, vk_.vkCreateFence(device_->device, &fence, device_->allocator, &frame.fence));
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device_->queueFamily;
    DPL_VK_MAKE(frame.commands, vk_.vkCreateCommandPool(device_->device, &pool, device_->allocator, &frame.commands));
    VkCommandBufferAllocateInfo allocation{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocation.commandPool = frame.commands;
    allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocation.commandBufferCount = 1;
    DPL_VK(vk_.vkAllocateCommandBuffers(device_->device, &allocation, &frame.commandBuffer));
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    DPL_VK(vk_.vkBeginCommandBuffer(frame.commandBuffer, &begin));
    Recorder{*this, frame.commandBuffer}.barrier();  // the frame before this one uses the same buffers
    DPL_RETURN_IF_ERROR(play(frame, frame.commandBuffer));
    DPL_VK(vk_.vkEndCommandBuffer(frame.commandBuffer));
    frame.steps.clear();
    return {};
}

Result<FrameId> VulkanBackend::createFrame(std::vector<Step> steps, FrameRun run) {
    DPL_RETURN_IF_ERROR(checkFrame(steps, *this, device_->info));
    std::vector<TargetId> drawnTargets;
    for (const Step& step : steps)
        if (const auto* draw = std::get_if<DrawStep>(&step)) drawnTargets.push_back(draw->target);
    const std::vector<BufferId> written = writtenBy(steps);
    Frame frame;
    frame.run = run;
    Status status = prepare(frame, std::move(steps));
    if (status && run == FrameRun::Submitted) status = record(frame);
    if (!status) {
        freeFrame(frame);
        return status.error();
    }
    for (const TargetId target : drawnTargets) targets_.at(target.value).drawn = true;
    for (const BufferId id : written) buffers_.at(id.value).written = true;
    frame.born = encoded();
    const FrameId id{newId()};
    frames_.emplace(id.value, std::move(frame));
    return id;
}

Status VulkanBackend::encode(FrameId id, uint32_t slot, AppCommands commands) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || it->second.run != FrameRun::Encoded) return fail(Code::InvalidArgument, "the encoded frame does not exist");
    DPL_RETURN_IF_ERROR(beginSlot(slot, commands));
    Frame& frame = it->second;
    if (frame.running) ended(frame);
    const auto buffer = static_cast<VkCommandBuffer>(commands.handle);
    Recorder recorder{*this, buffer};
    // The frame before this one uses the same buffers, an app's pass may read them, and readScene() may just have written one.
    recorder.barrier(kReaders, kReaders);
    if (unread_.target) recorder.makeReadable(targets_.at(unread_.target.value).surfaces[0].colour);
    DPL_RETURN_IF_ERROR(play(frame, buffer));
    endSlot(slot, commands);
    frame.running = true;
    frame.slot = slot;
    return {};
}

void VulkanBackend::barrierAfterSlot(AppCommands commands) {
    Recorder{*this, static_cast<VkCommandBuffer>(commands.handle)}.barrier(kGpuStages, kReaders);
}

void VulkanBackend::writeMark(uint32_t slot, uint64_t mark, AppCommands commands) {
    Recorder recorder{*this, static_cast<VkCommandBuffer>(commands.handle)};
    recorder.barrier();  // behind an earlier mark of the slot
    vk_.vkCmdFillBuffer(recorder.commands, marks_.buffer, slot * sizeof(uint32_t), sizeof(uint32_t), uint32_t(mark));
    recorder.hostBarrier();
}

void VulkanBackend::barrierBeforeCopies(AppCommands commands) {
    Recorder{*this, static_cast<VkCommandBuffer>(commands.handle)}.barrier();
}

/** Device: the device was lost. Asks it by a fence that no frame uses. */
Status VulkanBackend::checkPresent() {
    const VkResult status = vk_.vkGetFenceStatus(device_->device, fence_);
    return status == VK_ERROR_DEVICE_LOST ? Status(failVk("vkGetFenceStatus", status)) : Status();
}

void VulkanBackend::freeFrame(Frame& frame) {
    if (frame.run == FrameRun::Submitted) (void)waitFor(frame);
    vk_.vkDestroyFence(device_->device, frame.fence, device_->allocator);
    for (const VkQueryPool timestamps : frame.timestamps) vk_.vkDestroyQueryPool(device_->device, timestamps, device_->allocator);
    vk_.vkDestroyCommandPool(device_->device, frame.commands, device_->allocator);
    vk_.vkDestroyDescriptorPool(device_->device, frame.descriptors, device_->allocator);
    frame = {};
}

void VulkanBackend::destroyFrame(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end()) return;
    if (it->second.run == FrameRun::Encoded)
        retire(std::move(it->second), it->second.born);
    else
        freeFrame(it->second);
    frames_.erase(it);
}

Status VulkanBackend::submitAndWait(VkCommandBuffer commands) {
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    DPL_VK(vk_.vkResetFences(device_->device, 1, &fence_));
    {
        const Device::QueueLock lock(*device_);
        DPL_VK(vk_.vkQueueSubmit(device_->queue, 1, &submit, fence_));
    }
    return waitFor(fence_);
}

Status VulkanBackend::submit(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || it->second.run != FrameRun::Submitted)
        return fail(Code::InvalidArgument, "the submitted frame does not exist");
    Frame& frame = it->second;
    DPL_RETURN_IF_ERROR(waitFor(frame));
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &frame.commandBuffer;
    DPL_VK(vk_.vkResetFences(device_->device, 1, &frame.fence));
    {
        const Device::QueueLock lock(*device_);
        DPL_VK(vk_.vkQueueSubmit(device_->queue, 1, &submit, frame.fence));
    }
    frame.running = true;
    return {};
}

bool VulkanBackend::finished(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || !it->second.running) return true;
    if (it->second.run == FrameRun::Encoded) return false;  // the app knows; encode() learns it from the app's promise
    if (vk_.vkGetFenceStatus(device_->device, it->second.fence) != VK_SUCCESS) return false;
    ended(it->second);
    return true;
}

Status VulkanBackend::wait(FrameId id) {
    const auto it = frames_.find(id.value);
    return it == frames_.end() ? Status() : waitFor(it->second);
}

Status VulkanBackend::waitFor(Frame& frame) {
    if (!frame.running || frame.run == FrameRun::Encoded) return {};
    DPL_RETURN_IF_ERROR(waitFor(frame.fence));
    ended(frame);
    return {};
}

/** Waits for a fence of submitted commands. After an error the device is lost: then the commands do not run any more. */
Status VulkanBackend::waitFor(VkFence fence) {
    if (device_->lost) return failVk("vkWaitForFences", VK_ERROR_DEVICE_LOST);
    VkResult result = vk_.vkWaitForFences(device_->device, 1, &fence, VK_TRUE, kFrameTimeoutNs);
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(kFrameTimeoutNs);
    // A wait may run out of memory while the commands still run. Asking for the status of the fence goes on waiting.
    while (result != VK_SUCCESS && result != VK_TIMEOUT && result != VK_ERROR_DEVICE_LOST) {
        if (std::chrono::steady_clock::now() > end) {
            result = VK_TIMEOUT;
            break;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        result = vk_.vkGetFenceStatus(device_->device, fence);
    }
    if (result == VK_TIMEOUT) device_->lost = true;
    return result == VK_SUCCESS ? Status() : Status(failVk("vkWaitForFences", result));
}

/** Call it after the fence of a frame was signalled: then its timestamps can be read without waiting. */
void VulkanBackend::ended(Frame& frame) {
    frame.running = false;
    frame.unread = frame.timestamps[frame.nextTimestamps];
    if (frame.run == FrameRun::Encoded)
        frame.nextTimestamps ^= 1;
    else
        readAllTicks(frame);  // the next run writes the same pool
}

/** Reads timestamps of the pool `unread` into `ticks`. */
bool VulkanBackend::readTicks(Frame& frame, uint32_t first, uint32_t count) {
    const VkResult result = vk_.vkGetQueryPoolResults(device_->device, frame.unread, first, count, count * sizeof(uint64_t),
                                                      &frame.ticks[first], sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
    device_->lost |= result == VK_ERROR_DEVICE_LOST;
    return result == VK_SUCCESS;
}

void VulkanBackend::readAllTicks(Frame& frame) {
    if (!frame.unread) return;
    frame.timed = readTicks(frame, 0, uint32_t(frame.ticks.size()));
    frame.unread = VK_NULL_HANDLE;
}

Error VulkanBackend::failVk(std::string_view what, VkResult result) {
    device_->lost |= result == VK_ERROR_DEVICE_LOST;
    return vk::failVk(what, result);
}

std::vector<PassTime> VulkanBackend::passTimes(FrameId id) {
    std::vector<PassTime> times;
    const auto it = frames_.find(id.value);
    if (it == frames_.end()) return times;
    Frame& frame = it->second;
    readAllTicks(frame);
    if (!frame.timed) return times;
    for (size_t i = 0; i < frame.labels.size(); ++i) times.push_back({frame.labels[i], ticksMs(frame.ticks[i], frame.ticks[i + 1])});
    return times;
}

double VulkanBackend::frameMs(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end()) return 0;
    Frame& frame = it->second;
    // Every draw asks for this, so only two timestamps are read here.
    const auto last = uint32_t(frame.ticks.size() - 1);
    if (frame.unread) frame.timed = readTicks(frame, 0, 1) && readTicks(frame, last, 1);
    return frame.timed ? ticksMs(frame.ticks.front(), frame.ticks.back()) : 0;
}

double VulkanBackend::ticksMs(uint64_t from, uint64_t to) const {
    const uint64_t mask = device_->timestampBits >= 64 ? ~0ull : (1ull << device_->timestampBits) - 1;
    return double((to - from) & mask) * device_->nanosecondsPerTick * 1e-6;
}

}  // namespace dpl::vk
