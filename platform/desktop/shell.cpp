// SPDX-License-Identifier: Apache-2.0
#include "platform/desktop/shell.h"

#include <imgui.h>

#include "platform/common/frame_slots.h"
#include "platform/common/swapchain.h"
#include "platform/desktop/canvas.h"
#include "platform/desktop/gui.h"
#include "platform/desktop/window.h"

namespace dpl::platform {

struct Shell::Parts {  // each needs those before it
    std::unique_ptr<Window> window;
    std::unique_ptr<Device> device;
    std::unique_ptr<Canvas> canvas;
    std::unique_ptr<Room> room;
    std::unique_ptr<FloorShadows> shadows;
    std::unique_ptr<Pictures> pictures;
    std::unique_ptr<Gui> gui;
    std::unique_ptr<Swapchain> swapchain;
    std::unique_ptr<FrameSlots> slots;
};

Shell::Shell(const ShellInfo& info)
    : parts_(std::make_unique<Parts>()), fixedPicture_(info.fixedPicture), picturePx_{info.widthPx, info.heightPx} {}

Result<std::unique_ptr<Shell>> Shell::create(const ShellInfo& info) {
    std::unique_ptr<Shell> made(new Shell(info));
    DPL_SHELL_OK(made->makeParts(info));
    return made;
}

Status Shell::makeParts(const ShellInfo& info) {
    Parts& p = *parts_;
    const auto done = [&info](const char* step) {
        if (info.onStep) info.onStep(step);
    };
    DPL_SHELL_TRY(p.window, Window::create(info.title, info.widthPx, info.heightPx, !info.fixedPicture));
    done("window");
    DPL_SHELL_TRY(const Presentation presentation, p.window->presentation(info.validation));
    DPL_SHELL_TRY(p.device, Device::create(presentation));
    done("Vulkan instance and device");
    DPL_SHELL_TRY(p.canvas, Canvas::create(*p.device));
    const RoomPass roomPass{p.canvas->roomPass(), 0, kCanvasSamples, 0};
    DPL_SHELL_TRY(p.room, Room::create(p.device->handles(), roomPass));
    DPL_SHELL_TRY(p.shadows, FloorShadows::create(p.device->handles(), roomPass, kMaxStands));
    DPL_SHELL_TRY(p.pictures, Pictures::create(p.device->handles(), p.canvas->finishingPass()));
    done("pipelines of the room");
    const float scale = info.scale > 0 ? info.scale : info.fixedPicture ? 1 : p.window->screenScale();
    DPL_SHELL_TRY(p.gui, Gui::create(*p.window, *p.device, p.canvas->finishingPass(), DPL_VULKAN_SLOTS, scale));
    done("font and pipeline of the panels");
    DPL_SHELL_TRY(const VkSurfaceKHR surface, p.window->makeSurface(p.device->instance()));
    DPL_SHELL_TRY(p.swapchain, Swapchain::create(*p.device, surface, VK_IMAGE_USAGE_TRANSFER_DST_BIT));
    DPL_SHELL_TRY(p.slots, FrameSlots::create(*p.device));
    return {};
}

Shell::~Shell() {
    if (parts_->device) (void)waitIdle();  // fails if the device is lost; then nothing runs on it
}

DplVulkanDevice Shell::deviceForDoppel() {
    return parts_->device->forDoppel();
}

DplResult Shell::makeComposer(DplContext context, uint32_t* composer) const {
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.renderPass = parts_->canvas->composingPass();
    pass.colourFormat = kLightFormat;
    pass.samples = kCanvasSamples;
    return dplCreateVulkanComposer(context, &pass, composer);
}

const std::string& Shell::deviceName() const {
    return parts_->device->name();
}

bool Shell::beginFrame() {
    parts_->window->poll();
    if (parts_->window->wantsClose()) return false;
    if (!fixedPicture_) picturePx_ = parts_->window->sizePx();
    parts_->gui->beginFrame(picturePx_);
    return true;
}

Result<std::string> Shell::draw(const FrameContents& contents) {
    parts_->gui->endFrame();
    if (picturePx_.width == 0 || picturePx_.height == 0) return std::string();
    DPL_SHELL_OK(parts_->canvas->resize(picturePx_));
    const uint32_t slotIndex = uint32_t(frame_ % DPL_VULKAN_SLOTS);
    const FrameSlot& slot = parts_->slots->all[slotIndex];
    DPL_VK(vkWaitForFences(parts_->device->device(), 1, &slot.done, VK_TRUE, UINT64_MAX));
    DPL_SHELL_TRY(const std::optional<uint32_t> image, parts_->swapchain->acquire(parts_->window->sizePx(), slot.imageReady));
    if (!image) return std::string();
    ++frame_;

    const VkCommandBuffer commands = slot.commands;
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    DPL_VK(vkBeginCommandBuffer(commands, &begin));
    parts_->pictures->upload(commands, slotIndex);
    const Canvas& canvas = *parts_->canvas;
    canvas.beginRoom(commands);
    if (contents.room) {
        parts_->room->record(commands, picturePx_, &contents.view, 1, *contents.room);
        parts_->shadows->set(slotIndex, contents.shadows);
        parts_->shadows->record(commands, picturePx_, &contents.view, 1, slotIndex);
    }
    vkCmdEndRenderPass(commands);

    std::string problem;
    const bool wanted = contents.context && !contents.avatars.empty();
    bool prepared = false;
    if (wanted) {
        DplVulkanSceneDepth depth{};
        depth.structSize = sizeof depth;
        depth.image = canvas.depth();
        depth.layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
        depth.samples = kCanvasSamples;
        depth.scale = 0, depth.offset = kRoomNearM;
        prepared = dplVulkanPrepare(contents.context, commands, slotIndex, contents.avatars.data(), uint32_t(contents.avatars.size()),
                                    &contents.view, 1, contents.room ? &depth : nullptr) == DPL_OK;
        if (!prepared) problem = dplGetLastError();
    } else if (contents.context && dplVulkanUpload(contents.context, commands, slotIndex) != DPL_OK) {
        problem = dplGetLastError();
    }
    canvas.beginComposing(commands);
    if (prepared && dplVulkanCompose(contents.context, contents.composer, commands, slotIndex, 0, 0, 0) != DPL_OK)
        problem = dplGetLastError();
    vkCmdEndRenderPass(commands);
    canvas.beginFinishing(commands);
    parts_->pictures->record(commands, picturePx_, contents.pictures);
    if (contents.panels) DPL_SHELL_OK(parts_->gui->record(commands));
    vkCmdEndRenderPass(commands);
    parts_->swapchain->recordCopy(commands, *image, canvas.picture(), picturePx_);
    DPL_VK(vkEndCommandBuffer(commands));

    const VkPipelineStageFlags waitStage = VK_PIPELINE_STAGE_TRANSFER_BIT;
    const VkSemaphore drawn = parts_->swapchain->drawn(*image);
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.waitSemaphoreCount = 1;
    submit.pWaitSemaphores = &slot.imageReady;
    submit.pWaitDstStageMask = &waitStage;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    submit.signalSemaphoreCount = 1;
    submit.pSignalSemaphores = &drawn;
    DPL_VK(vkResetFences(parts_->device->device(), 1, &slot.done));
    DPL_SHELL_OK(parts_->device->submit(submit, slot.done));
    DPL_SHELL_OK(parts_->swapchain->present(*image));
    ++shown_;
    if (contents.rgb) DPL_SHELL_OK(readPicture(contents));
    return problem;
}

Status Shell::readPicture(const FrameContents& contents) {
    std::vector<uint8_t>& rgb = *contents.rgb;
    const size_t pixels = size_t(picturePx_.width) * picturePx_.height;
    DPL_SHELL_TRY(HostBuffer buffer, makeHostBuffer(parts_->device->handles(), pixels * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT));
    Status copied = parts_->device->runOnce([&](VkCommandBuffer commands) {
        if (contents.panels && !contents.rgbPanels) {  // the light of the frame is still there
            parts_->canvas->beginFinishing(commands);
            parts_->pictures->record(commands, picturePx_, contents.pictures);
            vkCmdEndRenderPass(commands);
        }
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {picturePx_.width, picturePx_.height, 1};
        vkCmdCopyImageToBuffer(commands, parts_->canvas->picture(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.buffer, 1, &region);
        VkMemoryBarrier host{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        host.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        host.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0, nullptr, 0, nullptr);
    });
    rgb.resize(copied ? pixels * 3 : 0);
    const auto* rgba = static_cast<const uint8_t*>(buffer.mapped);
    for (size_t i = 0; i < rgb.size() / 3; ++i)
        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = rgba[4 * i + c];
    destroyHostBuffer(parts_->device->handles(), buffer);
    return copied;
}

Result<uint32_t> Shell::addPicture(std::span<const uint8_t> rgba, uint32_t widthPx, uint32_t heightPx) {
    return parts_->pictures->add(rgba, {widthPx, heightPx});
}

void Shell::removePicture(uint32_t picture) {
    parts_->pictures->remove(picture);
}

Status Shell::buildRoom(const RoomPlan& plan) {
    DPL_SHELL_OK(waitIdle());
    parts_->room->build(plan);
    return {};
}

Status Shell::waitIdle() {
    return parts_->device->waitIdle();
}

void Shell::hideWindow() {
    parts_->window->hide();
}

std::vector<std::string> Shell::takeDropped() {
    return parts_->window->takeDropped();
}

std::vector<int> Shell::takeKeys() {
    std::vector<int> keys = parts_->window->takeKeys();
    if (ImGui::GetIO().WantTextInput) keys.clear();
    return keys;
}

std::vector<std::string> Shell::complaints() const {
    return parts_->device->complaints();
}

}  // namespace dpl::platform
