// SPDX-License-Identifier: Apache-2.0
// A program with a device, targets, passes and an avatar: what the tests of drawing in a program's frames have in common.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <deque>

#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/reference/composition.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/interop/app_device.h"

namespace dpl::test {

constexpr uint32_t kWidth = 96, kHeight = 80;
constexpr float kNear = 0.1f, kFar = 20;

/** The format in the referee's words. */
inline reference::TargetFormat refereeFormat(VkFormat format) {
    using enum reference::TargetFormat;
    switch (format) {
        case VK_FORMAT_B8G8R8A8_UNORM:
            return Bgra8;
        case VK_FORMAT_R8G8B8A8_SRGB:
            return Rgba8Srgb;
        case VK_FORMAT_B8G8R8A8_SRGB:
            return Bgra8Srgb;
        case VK_FORMAT_R16G16B16A16_SFLOAT:
            return Rgba16f;
        case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
            return A2b10g10r10;
        default:
            return Rgba8;
    }
}
inline double psnrDb(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, VkFormat format) {
    return reference::psnrDb(refereeFormat(format), a, b);
}

/** Turns a camera at frontCamera's place by 4 degrees about y, so that each eye of a pair is a frame of its own. */
inline void cant(DplCamera& camera) {
    const float c = std::cos(0.07f), s = std::sin(0.07f);
    const float turned[12] = {c, 0, s, -0.03f, 0, -1, 0, 1, s, 0, -c, 3};
    std::memcpy(camera.viewFromWorld, turned, sizeof turned);
}

/** A smooth background, in the bytes of a format. */
inline std::vector<uint8_t> background(VkFormat format) {
    const size_t bytes = reference::bytesOf(refereeFormat(format));
    std::vector<uint8_t> pixels(size_t(kWidth) * kHeight * bytes);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x)
            reference::pack(refereeFormat(format), {0.8 * x / kWidth, 0.9 * y / kHeight, 0.3, 1},
                            &pixels[(size_t(y) * kWidth + x) * bytes]);
    return pixels;
}

/**
 * Whether a pixel of the picture over a stored one may give `got`, on devices that keep Vulkan's rules:
 * - a step of 8 bits, because the GPU blends from codes, too; two where it encodes sRGB (an H200 is up to 1.6 codes off, lavapipe 1.0);
 * - quads keep the picture in halves, and the blit that makes the codes of a read-back may round a tie the other way.
 */
inline bool mayGive(VkFormat format, DplFill fill, const uint8_t* layer, const reference::StoredPixel& stored,
                    const reference::StoredPixel& got) {
    const double step = (reference::isSrgb(refereeFormat(format)) ? 2.01 : 1.01) / 255;
    const auto [low, high] = reference::overWithin(refereeFormat(format), layer, stored, fill == DPL_FILL_TILES ? 0 : 1);
    for (size_t c = 0; c < 3; ++c)
        if (got[c] < std::min(1.0, low[c]) - step || got[c] > std::min(1.0, high[c]) + step) return false;
    return true;
}

class Interop : public testing::Test {
protected:
    /** Opens a device of the test's own and a context on it, or skips. */
    void open(AppDevice::Options options = {}, DplFill fill = DPL_FILL_QUADS) {
        std::string why;
        app_ = AppDevice::open(options, why);
        if (!app_) GTEST_SKIP() << why;
        const DplVulkanDevice device = lent();
        const DplContextInfo info{sizeof info, DPL_RENDERER_AUTO, 1, 0, fill, nullptr};
        ASSERT_EQ(dplCreateVulkanContext(&device, &info, &context_), DPL_OK) << dplGetLastError();
        const auto bytes = tinyFile();
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &avatar_), DPL_OK) << dplGetLastError();
    }
    DplVulkanDevice lent() const {
        DplVulkanDevice device{};
        device.structSize = sizeof device;
        device.queueFamily = app_->family;
        device.instance = app_->instance, device.physicalDevice = app_->physical, device.device = app_->device, device.queue = app_->queue;
        device.enabledFeatures = &app_->enabled;
        device.lockQueue = lockQueue_, device.unlockQueue = unlockQueue_, device.user = user_;
        return device;
    }
    void TearDown() override {
        if (!app_) return;
        app_->waitAll();
        EXPECT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
        EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(app_->device, framebuffer, nullptr);
        for (VkRenderPass pass : passes_) vkDestroyRenderPass(app_->device, pass, nullptr);
        for (AppImage& image : images_) app_->destroy(image);
        for (const std::string& message : app_->messages) ADD_FAILURE() << message;
    }

    uint32_t composerFor(VkRenderPass pass, VkFormat format, uint32_t viewMask = 0, uint32_t samples = 1, uint32_t writesDepth = 0,
                         VkFormat depthFormat = VK_FORMAT_UNDEFINED) {
        DplVulkanPass desc{};
        desc.structSize = sizeof desc;
        desc.renderPass = pass, desc.viewMask = viewMask, desc.samples = samples, desc.colourFormat = format;
        desc.writesDepth = writesDepth, desc.depthFormat = depthFormat;
        uint32_t composer = 0;
        EXPECT_EQ(dplCreateVulkanComposer(context_, &desc, &composer), DPL_OK) << dplGetLastError();
        return composer;
    }

    /** Whether passes may have a view mask; else dplGetLastError() says why. */
    bool canMask() {
        DplVulkanPass desc{};
        desc.structSize = sizeof desc;
        passes_.push_back(desc.renderPass = app_->makePass(VK_FORMAT_R8G8B8A8_UNORM, 1, 3));
        desc.viewMask = 3, desc.colourFormat = VK_FORMAT_R8G8B8A8_UNORM;
        uint32_t composer = 0;
        return dplCreateVulkanComposer(context_, &desc, &composer) == DPL_OK;
    }

    /** A frame: prepare, then compose each view into its layer of the target by a pass without multiview, or all at once with it. */
    struct Passes {
        VkRenderPass pass = VK_NULL_HANDLE;  // null: dynamic rendering
        std::vector<VkFramebuffer> framebuffers;
        uint32_t composer = 0, viewMask = 0;
        const AppImage* depth = nullptr;  // of makeDepthTarget
        reference::StoredDepth stored{};  // in it; offset 0: the avatar's depth is not written
    };
    Passes passesFor(const AppImage& target, bool dynamic, uint32_t viewMask = 0, const AppImage* depth = nullptr,
                     uint32_t writesDepth = 0) {
        Passes made;
        made.viewMask = viewMask, made.depth = depth;
        const VkFormat depthFormat = depth ? depth->format : VK_FORMAT_UNDEFINED;
        const auto viewOf = [&](const AppImage& image, uint32_t i) { return viewMask ? image.view : image.layerViews[i]; };
        if (!dynamic) {
            passes_.push_back(made.pass = app_->makePass(target.format, target.samples, viewMask, depthFormat));
            for (uint32_t i = 0; i < (viewMask ? 1 : target.layers); ++i) {
                framebuffers_.push_back(
                    depth ? app_->makeFramebuffer(made.pass, {viewOf(target, i), viewOf(*depth, i)}, target.width, target.height)
                          : app_->makeFramebuffer(made.pass, {viewOf(target, i)}, target.width, target.height));
                made.framebuffers.push_back(framebuffers_.back());
            }
        }
        made.composer = composerFor(made.pass, target.format, viewMask, target.samples, writesDepth, depthFormat);
        return made;
    }
    AppImage& target(VkFormat format, uint32_t layers = 1, uint32_t samples = 1, uint32_t width = kWidth, uint32_t height = kHeight) {
        images_.push_back(app_->makeTarget(format, width, height, layers, samples));
        return images_.back();
    }

    DplResult frame(uint32_t slot, const AppImage& image, const Passes& passes, std::span<const DplAvatar> avatars,
                    std::span<const DplCamera> views, VkOffset2D at = {0, 0}, const DplVulkanSceneDepth* depths = nullptr) {
        const VkCommandBuffer commands = app_->begin(slot);
        DplResult result = dplVulkanPrepare(context_, commands, slot, avatars.data(), uint32_t(avatars.size()), views.data(),
                                            uint32_t(views.size()), depths);
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        for (uint32_t view = 0; view < (passes.viewMask ? 1 : views.size()) && result == DPL_OK; ++view) {
            beginPass(commands, image, passes, view);
            result = dplVulkanCompose(context_, passes.composer, commands, slot, view, at.x, at.y);
            if (result == DPL_OK && passes.stored.offset != 0)
                result = dplVulkanComposeDepth(context_, passes.composer, commands, slot, view, at.x, at.y, float(passes.stored.scale),
                                               float(passes.stored.offset));
            endPass(commands, passes);
        }
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_->submit(slot);
        return result;
    }
    void beginPass(VkCommandBuffer commands, const AppImage& image, const Passes& passes, uint32_t view) {
        if (passes.pass) {
            VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
            begin.renderPass = passes.pass;
            begin.framebuffer = passes.framebuffers[view];
            begin.renderArea.extent = {image.width, image.height};
            vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            return;
        }
        VkRenderingAttachmentInfo colour{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
        colour.imageView = passes.viewMask ? image.view : image.layerViews[view];
        colour.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        colour.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
        colour.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
        info.renderArea.extent = {image.width, image.height};
        info.layerCount = 1;
        info.viewMask = passes.viewMask;
        info.colorAttachmentCount = 1;
        info.pColorAttachments = &colour;
        VkRenderingAttachmentInfo depth = colour;
        if (passes.depth) {
            depth.imageView = passes.viewMask ? passes.depth->view : passes.depth->layerViews[view];
            depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
            info.pDepthAttachment = &depth;
        }
        vkCmdBeginRendering(commands, &info);
    }
    void endPass(VkCommandBuffer commands, const Passes& passes) {
        if (passes.pass)
            vkCmdEndRenderPass(commands);
        else
            vkCmdEndRendering(commands);
    }

    /** What dplRender of the same context draws. depthM: of the splats, meshDepthM: of the mesh; null: not wanted. */
    std::vector<uint8_t> layerOf(const DplCamera& camera, std::vector<float>* depthM = nullptr, std::vector<float>* meshDepthM = nullptr) {
        const size_t count = size_t(camera.widthPx) * camera.heightPx;
        std::vector<uint8_t> pixels(count * 4);
        DplImage image{sizeof(DplImage), 0, pixels.data(), pixels.size(), 0, nullptr, 0};
        if (depthM) depthM->resize(count), image.depthM = depthM->data(), image.depthCount = count;
        if (meshDepthM) meshDepthM->resize(count), image.meshDepthM = meshDepthM->data(), image.meshDepthCount = count;
        EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
        return pixels;
    }
    std::vector<uint8_t> layerOfTheCpu(const DplCamera& camera) const {
        const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE, 1};
        DplContext cpu = nullptr;
        DplAvatar avatar = nullptr;
        const auto bytes = tinyFile();
        std::vector<uint8_t> pixels(size_t(camera.widthPx) * camera.heightPx * 4);
        const DplImage image{sizeof(DplImage), 0, pixels.data(), pixels.size(), 0, nullptr, 0};
        EXPECT_EQ(dplCreateContext(&software, &cpu), DPL_OK) << dplGetLastError();
        EXPECT_EQ(dplLoadAvatar(cpu, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
        EXPECT_EQ(dplRender(cpu, avatar, &camera, 1, &image), DPL_OK) << dplGetLastError();
        dplDestroyAvatar(avatar), dplDestroyContext(cpu);
        return pixels;
    }
    /** The picture of dplRender, composed over `under` by the referee. */
    std::vector<uint8_t> composed(const DplCamera& camera, VkFormat format, std::vector<uint8_t> under) {
        reference::compose(refereeFormat(format), layerOf(camera), under);
        return under;
    }

    void (*lockQueue_)(void*) = nullptr;
    void (*unlockQueue_)(void*) = nullptr;
    void* user_ = nullptr;
    std::unique_ptr<AppDevice> app_;
    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    std::deque<AppImage> images_;
    std::vector<VkRenderPass> passes_;
    std::vector<VkFramebuffer> framebuffers_;
};

#define OPEN_OR_SKIP(...) \
    open(__VA_ARGS__);    \
    if (IsSkipped() || HasFatalFailure()) return

}  // namespace dpl::test
