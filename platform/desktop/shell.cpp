// SPDX-License-Identifier: Apache-2.0
#include "platform/desktop/shell.h"

#include <imgui.h>

#include "platform/common/frame_slots.h"
#include "platform/common/swapchain.h"
#include "platform/desktop/canvas.h"
#include "platform/desktop/gui.h"
#include "platform/desktop/window.h"

namespace dpl::platform {

/** What lives on a device; each needs those before it. */
struct OnDevice {
    std::unique_ptr<Device> device;
    std::unique_ptr<Canvas> canvas;
    std::unique_ptr<Room> room;
    std::unique_ptr<FloorShadows> shadows;
    std::unique_ptr<Pictures> pictures;
    std::unique_ptr<Swapchain> swapchain;
    std::unique_ptr<FrameSlots> slots;

    void clear() { slots.reset(), swapchain.reset(), pictures.reset(), shadows.reset(), room.reset(), canvas.reset(), device.reset(); }
};

struct Shell::Parts : OnDevice {
    std::unique_ptr<Window> window;
    OnDevice lost;             // its device and pictures, until contexts and pictures have moved
    std::unique_ptr<Gui> gui;  // draws by the device: it goes first
    ~Parts() {
        gui.reset();
        clear(), lost.clear();
    }
};

Shell::Shell(const ShellInfo& info) : info_(info), parts_(std::make_unique<Parts>()), picturePx_{info.widthPx, info.heightPx} {}

Result<std::unique_ptr<Shell>> Shell::create(const ShellInfo& info, const std::function<bool(const Error&)>& opensAgain) {
    std::unique_ptr<Shell> made(new Shell(info));
    Status opened = made->makeParts();
    while (!opened && opened.error().code == DPL_ERROR_DEVICE && opensAgain && opensAgain(opened.error())) opened = made->rebuild();
    if (!opened) return opened.error();
    made->forgetLostDevice();
    return made;
}

Status Shell::makeParts() {
    DPL_SHELL_TRY(parts_->window, Window::create(info_.title, info_.widthPx, info_.heightPx, !info_.fixedPicture));
    if (info_.onStep) info_.onStep("window");
    return makeOnDevice();
}

Status Shell::makeOnDevice() {
    Parts& p = *parts_;
    const auto done = [this](const char* step) {
        if (info_.onStep) info_.onStep(step);
    };
    DPL_SHELL_TRY(const Presentation presentation, p.window->presentation(info_.validation));
    DPL_SHELL_TRY(p.device, Device::create(presentation));
    done("Vulkan instance and device");
    DPL_SHELL_TRY(p.canvas, Canvas::create(*p.device));
    const RoomPass roomPass{p.canvas->roomPass(), 0, kCanvasSamples, 0};
    DPL_SHELL_TRY(p.room, Room::create(p.device->handles(), roomPass));
    DPL_SHELL_TRY(p.shadows, FloorShadows::create(p.device->handles(), roomPass, kMaxStands));
    DPL_SHELL_TRY(p.pictures, Pictures::create(p.device->handles(), p.canvas->finishingPass()));
    done("pipelines of the room");
    if (!p.gui) p.gui = Gui::create(*p.window, info_.scale > 0 ? info_.scale : info_.fixedPicture ? 1 : p.window->screenScale());
    DPL_SHELL_OK(p.gui->enter(*p.device, p.canvas->finishingPass(), DPL_VULKAN_SLOTS));
    done("font and pipeline of the panels");
    DPL_SHELL_TRY(const VkSurfaceKHR surface, p.window->makeSurface(p.device->instance()));
    DPL_SHELL_TRY(p.swapchain, Swapchain::create(*p.device, surface, VK_IMAGE_USAGE_TRANSFER_DST_BIT));
    DPL_SHELL_TRY(p.slots, FrameSlots::create(*p.device));
    return {};
}

Status Shell::rebuild() {
    Parts& p = *parts_;
    if (p.device) {
        (void)waitIdle();  // fails if the device is lost; then nothing runs on it
        if (p.gui) p.gui->leave();
        p.slots.reset(), p.swapchain.reset(), p.shadows.reset(), p.room.reset(), p.canvas.reset();
        if (!p.lost.device) p.lost.pictures = std::move(p.pictures), p.lost.device = std::move(p.device);
        p.clear();  // what an attempt before has made, on a device that no context has seen
    }
    DPL_SHELL_OK(makeOnDevice());
    if (p.lost.pictures) DPL_SHELL_OK(p.pictures->takeOver(*p.lost.pictures));
    if (plan_) p.room->build(*plan_);
    return {};
}

void Shell::forgetLostDevice() {
    if (!parts_->lost.device) return;
    for (std::string& complaint : parts_->lost.device->complaints()) complaints_.push_back(std::move(complaint));
    parts_->lost.clear();
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
    if (!info_.fixedPicture) picturePx_ = parts_->window->sizePx();
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
    DplResult met = DPL_OK;  // the error of Doppel's calls
    const auto failed = [&](DplResult result) {
        if (result != DPL_OK) met = result, problem = dplGetLastError();
        return result != DPL_OK;
    };
    const bool wanted = contents.context && !contents.avatars.empty();
    bool prepared = false;
    if (wanted) {
        DplVulkanSceneDepth depth{};
        depth.structSize = sizeof depth;
        depth.image = canvas.depth();
        depth.layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
        depth.samples = kCanvasSamples;
        depth.scale = 0, depth.offset = kRoomNearM;
        prepared = !failed(dplVulkanPrepare(contents.context, commands, slotIndex, contents.avatars.data(),
                                            uint32_t(contents.avatars.size()), &contents.view, 1, contents.room ? &depth : nullptr));
    } else if (contents.context) {
        failed(dplVulkanUpload(contents.context, commands, slotIndex));
    }
    canvas.beginComposing(commands);
    if (prepared) failed(dplVulkanCompose(contents.context, contents.composer, commands, slotIndex, 0, 0, 0));
    if (met == DPL_ERROR_DEVICE) return Error{met, problem};
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
    plan_ = plan;
    return {};
}

Status Shell::waitIdle() {
    if (!parts_->device) return {};
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
    std::vector<std::string> all = complaints_;
    for (const auto* device : {&parts_->lost.device, &parts_->device})
        if (*device)
            for (std::string& complaint : (*device)->complaints()) all.push_back(std::move(complaint));
    return all;
}

}  // namespace dpl::platform
