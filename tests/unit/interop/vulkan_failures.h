// SPDX-License-Identifier: Apache-2.0
// A program with a Vulkan that fails, and the calls of Doppel in which it does.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/interop/app_device.h"
#include "tests/unit/interop/failing_vulkan.h"

namespace dpl::test {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSide = 48;       // of the target
constexpr size_t kMostMemory = 200;  // allocations of one avatar and the frames of the four sizes that are kept; measured: 130

/** Memory for the driver's objects that runs out, and is counted. The driver may allocate on threads of its own. */
class FailingAllocator {
public:
    FailingAllocator() {
        callbacks.pUserData = this;
        callbacks.pfnAllocation = [](void* self, size_t size, size_t alignment, VkSystemAllocationScope) {
            return static_cast<FailingAllocator*>(self)->allocate(size, alignment);
        };
        callbacks.pfnReallocation = [](void* self, void* old, size_t size, size_t alignment, VkSystemAllocationScope) {
            return static_cast<FailingAllocator*>(self)->reallocate(old, size, alignment);
        };
        callbacks.pfnFree = [](void* self, void* memory) { static_cast<FailingAllocator*>(self)->free(memory); };
    }
    void failAt(uint64_t allocation) { count_ = 0, failAt_ = allocation, failed_ = false; }
    bool failed() const { return failed_; }
    size_t live() const { return sizes_.size(); }

    VkAllocationCallbacks callbacks{};

private:
    void* allocate(size_t size, size_t alignment) {
        std::lock_guard lock(mutex_);
        // Commands return no errors, and lavapipe 22.3.6 crashes if an allocation fails while one is recorded.
        if (!failingVulkan().recording() && ++count_ == failAt_) return failed_ = true, nullptr;
        void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
        if (memory) sizes_[memory] = size;
        return memory;
    }
    void* reallocate(void* old, size_t size, size_t alignment) {
        void* memory = size ? allocate(size, alignment) : nullptr;
        if (old && (memory || !size)) {
            if (memory) std::memcpy(memory, old, std::min(size, sizes_[old]));
            free(old);
        }
        return memory;
    }
    void free(void* memory) {
        std::lock_guard lock(mutex_);
        sizes_.erase(memory);
        std::free(memory);
    }

    std::mutex mutex_;
    std::map<void*, size_t> sizes_;
    uint64_t count_ = 0, failAt_ = 0;
    bool failed_ = false;
};

class VulkanFailures : public testing::Test {
protected:
    void SetUp() override {
        vulkan_.mend();
        vulkan_.everCalled.clear(), vulkan_.everFailed.clear();
        std::string why;
        if (!openProgram(why)) GTEST_SKIP() << why;
        file_ = tinyFile();
        dplSetLogCallback([](void*, DplLogLevel, const char*) {}, nullptr);
    }
    void TearDown() override {
        dplSetLogCallback(nullptr, nullptr);
        if (!program_.app) return;
        vulkan_.mend();
        close();
        program_.close();
    }
    /** A program with a target and a pass. */
    struct Program {
        std::unique_ptr<AppDevice> app;
        AppImage image;
        VkRenderPass pass = VK_NULL_HANDLE;
        VkFramebuffer framebuffer = VK_NULL_HANDLE;

        void close() {
            app->waitAll();
            vkDestroyFramebuffer(app->device, framebuffer, nullptr);
            vkDestroyRenderPass(app->device, pass, nullptr);
            app->destroy(image);
            for (const std::string& message : app->messages) ADD_FAILURE() << message;
            app.reset();
        }
    };
    bool openProgram(std::string& why) {
        Program made;
        made.app = AppDevice::open({.multiview = false}, why);
        if (!made.app) return false;
        made.image = made.app->makeTarget(kFormat, kSide, kSide);
        made.pass = made.app->makePass(kFormat, 1, 0);
        made.framebuffer = made.app->makeFramebuffer(made.pass, {made.image.layerViews[0]}, kSide, kSide);
        program_ = std::move(made);
        return true;
    }

    DplVulkanDevice lent() const {
        DplVulkanDevice device{};
        device.structSize = sizeof device;
        device.getInstanceProcAddr = vulkan_.entry();
        device.queueFamily = program_.app->family;
        device.instance = program_.app->instance, device.physicalDevice = program_.app->physical, device.device = program_.app->device,
        device.queue = program_.app->queue;
        device.enabledFeatures = &program_.app->enabled;
        if (allocator_) device.allocator = &allocator_->callbacks;
        return device;
    }
    DplResult create(DplFill fill = DPL_FILL_QUADS) {
        const DplVulkanDevice device = lent();
        const DplContextInfo info{sizeof info, DPL_RENDERER_AUTO, 1, 0, fill, nullptr};
        return dplCreateVulkanContext(&device, &info, &context_);
    }
    DplResult load() { return dplLoadAvatar(context_, file_.data(), file_.size(), &avatar_); }
    DplResult rebuild() {
        const DplVulkanDevice device = lent();
        return dplRebuildVulkan(context_, &device);
    }
    DplResult compose() {
        DplVulkanPass pass{};
        pass.structSize = sizeof pass;
        pass.renderPass = program_.pass, pass.colourFormat = kFormat;
        return dplCreateVulkanComposer(context_, &pass, &composer_);
    }
    void open(DplFill fill = DPL_FILL_QUADS) {
        ASSERT_EQ(create(fill), DPL_OK) << dplGetLastError();
        ASSERT_EQ(load(), DPL_OK) << dplGetLastError();
        ASSERT_EQ(compose(), DPL_OK) << dplGetLastError();
    }
    /** Destroys the avatar and the context. Nothing of Doppel's is left in Vulkan. */
    void close() {
        program_.app->waitAll();
        EXPECT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
        EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        avatar_ = nullptr, context_ = nullptr;
        EXPECT_EQ(vulkan_.live(), 0u) << vulkan_.liveTypes();
        for (const std::string& mistake : vulkan_.mistakes()) ADD_FAILURE() << mistake;
    }

    static DplCamera camera(uint32_t size) { return frontCamera(16 + size % 32, 16 + size / 32 % 32); }

    /** Prepares and composes a frame. The commands run even if prepare fails; then nothing can be composed. */
    DplResult frame(uint32_t slot, const DplCamera& view) {
        const VkCommandBuffer commands = program_.app->begin(slot);
        const DplResult prepared = dplVulkanPrepare(context_, commands, slot, &avatar_, 1, &view, 1, nullptr);
        const std::string sentence = dplGetLastError();
        program_.app->barrier(commands, program_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        begin.renderPass = program_.pass, begin.framebuffer = program_.framebuffer, begin.renderArea.extent = {kSide, kSide};
        vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        const DplResult composed = dplVulkanCompose(context_, composer_, commands, slot, 0, 0, 0);
        EXPECT_EQ(composed == DPL_OK, prepared == DPL_OK) << "what was not prepared cannot be composed: " << dplGetLastError();
        vkCmdEndRenderPass(commands);
        program_.app->barrier(commands, program_.image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        program_.app->submit(slot);
        lastError_ = sentence;
        return prepared;
    }
    std::vector<uint8_t> framed(const DplCamera& view) {
        program_.app->upload(program_.image, 0, std::vector<uint8_t>(size_t(kSide) * kSide * 4));
        EXPECT_EQ(frame(0, view), DPL_OK) << lastError_;
        return program_.app->download(program_.image, 0);
    }
    DplResult makeTarget() {
        const AppImage& image = program_.image;
        const VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        const DplVulkanTarget desc{sizeof desc, 1, {image.layerViews[0]}, kFormat, 1, 0, kSide, kSide, layout, layout};
        return dplCreateVulkanTarget(context_, &desc, &target_);
    }
    /** Draws a frame by Doppel's own submission, and waits until it has run. */
    DplResult submit(uint32_t slot, const DplCamera& view) {
        const DplVulkanSubmission how{sizeof how};
        const DplResult result = dplVulkanSubmit(context_, target_, slot, &avatar_, 1, &view, 1, nullptr, &how);
        vkDeviceWaitIdle(program_.app->device);
        return result;
    }
    std::vector<uint8_t> submitted(const DplCamera& view) {
        program_.app->upload(program_.image, 0, std::vector<uint8_t>(size_t(kSide) * kSide * 4));
        EXPECT_EQ(submit(0, view), DPL_OK) << dplGetLastError();
        return program_.app->download(program_.image, 0);
    }
    DplResult render(const DplCamera& view, std::vector<uint8_t>& pixels) {
        pixels.assign(size_t(view.widthPx) * view.heightPx * 4, 0xAA);
        const DplImage image{sizeof(DplImage), 0, pixels.data(), pixels.size(), 0, nullptr, 0};
        return dplRender(context_, avatar_, &view, 1, &image);
    }

    struct Sweep {
        uint64_t attempts = 0, failed = 0;  // attempts that failed
    };
    /** Calls attempt(n) for n = 1, 2, 3 ...; in the nth attempt, its nth call fails, or its nth allocation if there is an allocator. Ends
     *  with the first attempt that makes fewer. An attempt may succeed in spite of a failure; then it must have done its work, which `undo`
     *  checks and undoes. */
    Sweep sweep(const std::function<DplResult(uint64_t)>& attempt, const std::function<void(uint64_t)>& undo) {
        Sweep result;
        for (uint64_t n = 1; n < 3000; ++n) {
            if (allocator_)
                allocator_->failAt(n);
            else
                vulkan_.failAt(n, n % 2 ? VK_ERROR_OUT_OF_DEVICE_MEMORY : VK_ERROR_OUT_OF_HOST_MEMORY);
            lastError_.clear();
            const DplResult got = attempt(n);
            if (lastError_.empty()) lastError_ = dplGetLastError();
            const std::string where = !allocator_ ? vulkan_.failed() : allocator_->failed() ? "an allocation" : "";
            vulkan_.mend();
            if (allocator_) allocator_->failAt(0);
            ++result.attempts;
            EXPECT_LT(vulkan_.liveMemory(), kMostMemory) << where << ": failed calls keep memory";
            if (got == DPL_OK) {
                undo(n);
            } else {
                ++result.failed;
                EXPECT_EQ(got, DPL_ERROR_OUT_OF_MEMORY) << where << ": " << lastError_;
                EXPECT_NE(lastError_.find("memory"), std::string::npos) << where << ": " << lastError_;
            }
            if (where.empty()) return result;
        }
        ADD_FAILURE() << "the sweep does not end";
        return result;
    }
    /** Whether less than the file holds was loaded. */
    static bool isLean(DplAvatar avatar) {
        DplAvatarInfo info{};
        info.structSize = sizeof info;
        EXPECT_EQ(dplGetAvatarInfo(avatar, &info), DPL_OK) << dplGetLastError();
        return info.splatCount < info.fileSplatCount || info.shDegree < info.fileShDegree;
    }
    static void print(const char* what, const Sweep& s) {
        std::printf("%s: %llu attempts, %llu of them failed\n", what, (unsigned long long)s.attempts, (unsigned long long)s.failed);
    }

    FailingVulkan& vulkan_ = failingVulkan();
    Program program_;
    std::vector<uint8_t> file_;
    std::unique_ptr<FailingAllocator> allocator_;  // null: the driver's own
    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    uint32_t composer_ = 0, target_ = 0;
    std::string lastError_;
};

}  // namespace dpl::test
