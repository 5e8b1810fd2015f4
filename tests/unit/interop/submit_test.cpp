// SPDX-License-Identifier: Apache-2.0
// Avatars drawn over a program's images by Doppel's own submissions: the bytes of the recorded form, ordered by the program's binary or
// timeline semaphores, without a wait on the CPU.
#include "apps/bench/count_allocations.h"
#include "tests/unit/interop/interop_fixture.h"

namespace dpl::test {
namespace {

constexpr uint64_t kSoonNs = 50'000'000, kLateNs = 60'000'000'000;

class InteropSubmit : public Interop {
protected:
    void TearDown() override {
        if (app_) {
            vkDeviceWaitIdle(app_->device);
            for (VkSemaphore semaphore : semaphores_) vkDestroySemaphore(app_->device, semaphore, nullptr);
            for (VkFence fence : fences_) vkDestroyFence(app_->device, fence, nullptr);
        }
        Interop::TearDown();
    }
    VkSemaphore semaphore(bool timeline = false) {
        VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
        if (timeline) info.pNext = &type;
        MUST(vkCreateSemaphore(app_->device, &info, nullptr, &semaphores_.emplace_back()));
        return semaphores_.back();
    }
    VkFence fence() {
        const VkFenceCreateInfo info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        MUST(vkCreateFence(app_->device, &info, nullptr, &fences_.emplace_back()));
        return fences_.back();
    }
    VkResult waitFor(VkFence fence, uint64_t ns = kLateNs) { return vkWaitForFences(app_->device, 1, &fence, VK_TRUE, ns); }
    void waitAndReset(VkFence fence) {
        MUST(waitFor(fence));
        MUST(vkResetFences(app_->device, 1, &fence));
    }

    /** Of an image that lies in TRANSFER_SRC_OPTIMAL between submissions, as all of AppDevice. */
    static DplVulkanTarget describe(const AppImage& image, uint32_t viewMask = 0) {
        DplVulkanTarget desc{};
        desc.structSize = sizeof desc;
        desc.imageCount = viewMask ? 1 : image.layers, desc.viewMask = viewMask;
        for (uint32_t i = 0; i < desc.imageCount; ++i) desc.images[i] = viewMask ? image.view : image.layerViews[i];
        desc.format = image.format, desc.samples = image.samples;
        desc.widthPx = image.width, desc.heightPx = image.height;
        desc.layoutBefore = desc.layoutAfter = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        return desc;
    }
    uint32_t targetOf(const AppImage& image, uint32_t viewMask = 0) {
        const DplVulkanTarget desc = describe(image, viewMask);
        uint32_t made = 0;
        EXPECT_EQ(dplCreateVulkanTarget(context_, &desc, &made), DPL_OK) << dplGetLastError();
        return made;
    }
    DplResult submit(uint32_t target, uint32_t slot, std::span<const DplCamera> views, const DplVulkanSubmission& how) {
        return dplVulkanSubmit(context_, target, slot, &avatar_, 1, views.data(), uint32_t(views.size()), nullptr, &how);
    }
    static bool says(const char* text) { return std::string(dplGetLastError()).find(text) != std::string::npos; }

    std::vector<VkSemaphore> semaphores_;
    std::vector<VkFence> fences_;
};

TEST_F(InteropSubmit, drawsTheBytesOfTheRecordedForm) {
    OPEN_OR_SKIP({.multiview = false});
    DplCamera eyes[2] = {frontCamera(kWidth, kHeight, 0.03f), frontCamera(kWidth, kHeight, -0.03f)};
    const VkFence done = fence();
    for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT})
        for (const uint32_t views : {1u, 2u})
            for (const bool canted : {false, true}) {
                if (canted) cant(eyes[1]);
                const std::vector<uint8_t> under = background(format);
                const AppImage &recorded = target(format, views), &submitted = target(format, views);
                for (uint32_t eye = 0; eye < views; ++eye) app_->upload(recorded, eye, under), app_->upload(submitted, eye, under);
                ASSERT_EQ(frame(0, recorded, passesFor(recorded, false), {&avatar_, 1}, {eyes, views}, {-7, 11}), DPL_OK);
                DplVulkanSubmission how{sizeof how, -7, 11};
                how.fence = done;
                ASSERT_EQ(submit(targetOf(submitted), 1, {eyes, views}, how), DPL_OK) << dplGetLastError();
                waitAndReset(done);
                for (uint32_t eye = 0; eye < views; ++eye) {
                    const auto drawn = app_->download(submitted, eye);
                    EXPECT_EQ(drawn, app_->download(recorded, eye)) << "format " << format << ", eye " << eye;
                    EXPECT_NE(drawn, under);
                }
            }
}

TEST_F(InteropSubmit, fillsArraysByMultiview) {
    OPEN_OR_SKIP({});
    if (!canMask()) GTEST_SKIP() << dplGetLastError();
    const DplCamera eyes[2] = {frontCamera(kWidth, kHeight, 0.03f), frontCamera(kWidth, kHeight, -0.03f)};
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_SRGB;
    const AppImage &recorded = target(kFormat, 2), &submitted = target(kFormat, 2);
    const std::vector<uint8_t> under = background(kFormat);
    for (uint32_t eye = 0; eye < 2; ++eye) app_->upload(recorded, eye, under), app_->upload(submitted, eye, under);
    ASSERT_EQ(frame(0, recorded, passesFor(recorded, false, 3), {&avatar_, 1}, eyes), DPL_OK) << dplGetLastError();
    DplVulkanSubmission how{sizeof how};
    how.fence = fence();
    ASSERT_EQ(submit(targetOf(submitted, 3), 1, eyes, how), DPL_OK) << dplGetLastError();
    MUST(waitFor(how.fence));
    for (uint32_t eye = 0; eye < 2; ++eye) EXPECT_EQ(app_->download(submitted, eye), app_->download(recorded, eye));
}

TEST_F(InteropSubmit, binarySemaphoresOrderItBetweenTheProgramsSubmissions) {
    OPEN_OR_SKIP({.multiview = false});
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const AppImage &image = target(kFormat), &copy = target(kFormat);
    const uint32_t made = targetOf(image);
    const VkSemaphore painted = semaphore(), drawn = semaphore();
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    for (uint32_t n = 0; n < 5; ++n) {
        const uint32_t slot = n % DPL_VULKAN_SLOTS;
        VkCommandBuffer commands = app_->begin(0);
        const VkClearColorValue grey{{128 / 255.0f, 128 / 255.0f, 128 / 255.0f, 1}};  // a code: devices may round 0.5 either way
        const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        vkCmdClearColorImage(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &grey, 1, &whole);
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_->submit(0, VK_NULL_HANDLE, painted);
        DplVulkanSubmission how{sizeof how};
        how.waitCount = 1, how.waits = &painted, how.waitStages = &stage;
        how.signalCount = 1, how.signals = &drawn;
        ASSERT_EQ(submit(made, slot, {&camera, 1}, how), DPL_OK) << dplGetLastError();
        commands = app_->begin(1);
        app_->barrier(commands, copy, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        const VkImageSubresourceLayers layer{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        const VkImageCopy region{layer, {}, layer, {}, {kWidth, kHeight, 1}};
        vkCmdCopyImage(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, copy.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                       &region);
        app_->barrier(commands, copy, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_->submit(1, drawn);
        app_->waitAll();
    }
    std::vector<uint8_t> under(size_t(kWidth) * kHeight * 4);
    for (size_t i = 0; i < under.size(); ++i) under[i] = i % 4 == 3 ? 255 : 128;
    EXPECT_GT(psnrDb(app_->download(copy, 0), composed(camera, kFormat, under), kFormat), 60);
}

TEST_F(InteropSubmit, timelineSemaphoresHoldItBackAndTellWhenItIsDone) {
    OPEN_OR_SKIP({.multiview = false, .timeline = true});
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    const uint32_t made = targetOf(image);
    const VkSemaphore line = semaphore(true);
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const uint64_t start = 5, end = 9;
    DplVulkanSubmission how{sizeof how};
    how.waitCount = how.signalCount = 1;
    how.waits = how.signals = &line, how.waitStages = &stage, how.waitValues = &start, how.signalValues = &end;
    how.fence = fence();
    ASSERT_EQ(submit(made, 0, {&camera, 1}, how), DPL_OK) << dplGetLastError();
    EXPECT_EQ(waitFor(how.fence, kSoonNs), VK_TIMEOUT) << "it waits for the program's value, and this thread did not";
    DplVulkanSubmission early{sizeof early};
    EXPECT_EQ(submit(made, 0, {&camera, 1}, early), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("slot 0")) << dplGetLastError();
    VkSemaphoreSignalInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO};
    signal.semaphore = line, signal.value = start;
    MUST(vkSignalSemaphore(app_->device, &signal));
    MUST(waitFor(how.fence));
    VkSemaphoreWaitInfo reached{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
    reached.semaphoreCount = 1, reached.pSemaphores = &line, reached.pValues = &end;
    EXPECT_EQ(vkWaitSemaphores(app_->device, &reached, kLateNs), VK_SUCCESS);
    EXPECT_EQ(submit(made, 0, {&camera, 1}, early), DPL_OK) << dplGetLastError();
    vkDeviceWaitIdle(app_->device);
}

TEST_F(InteropSubmit, theQueueIsLockedForEachSubmissionAndNothingIsAllocated) {
    struct Locks {
        int taken = 0, held = 0, worst = 0;
    } locks;
    user_ = &locks;
    lockQueue_ = [](void* user) {
        auto& l = *static_cast<Locks*>(user);
        ++l.taken, l.worst = std::max(l.worst, ++l.held);
    };
    unlockQueue_ = [](void* user) { --static_cast<Locks*>(user)->held; };
    OPEN_OR_SKIP({.multiview = false, .validation = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_SRGB);
    const uint32_t made = targetOf(image);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    VkFence fences[DPL_VULKAN_SLOTS];
    for (VkFence& f : fences) f = fence();
    locks.taken = 0;
    for (uint32_t n = 0; n < 12; ++n) {
        const uint32_t slot = n % DPL_VULKAN_SLOTS;
        if (n >= DPL_VULKAN_SLOTS) waitAndReset(fences[slot]);
        ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.05 * n, DPL_TRUE), DPL_OK);
        DplVulkanSubmission how{sizeof how};
        how.fence = fences[slot];
        AllocationCount count(CountedThreads::Own);
        ASSERT_EQ(submit(made, slot, {&camera, 1}, how), DPL_OK) << dplGetLastError();
        const uint64_t allocations = count.stop();
        if (n >= DPL_VULKAN_SLOTS) {
            EXPECT_EQ(allocations, 0u);
        }
        EXPECT_EQ(locks.taken, int(n) + 1);
    }
    EXPECT_EQ(locks.held, 0);
    EXPECT_EQ(locks.worst, 1);
    vkDeviceWaitIdle(app_->device);
}

TEST_F(InteropSubmit, targetsGoWhileSubmissionsRun) {
    OPEN_OR_SKIP({.multiview = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    VkFence fences[DPL_VULKAN_SLOTS];
    for (VkFence& f : fences) f = fence();
    for (uint32_t n = 0; n < 9; ++n) {
        const uint32_t slot = n % DPL_VULKAN_SLOTS;
        if (n >= DPL_VULKAN_SLOTS) waitAndReset(fences[slot]);
        const uint32_t made = targetOf(image);
        DplVulkanSubmission how{sizeof how};
        how.fence = fences[slot];
        ASSERT_EQ(submit(made, slot, {&camera, 1}, how), DPL_OK) << dplGetLastError();
        ASSERT_EQ(dplDestroyVulkanTarget(context_, made), DPL_OK) << dplGetLastError();
        EXPECT_EQ(dplDestroyVulkanTarget(context_, made), DPL_ERROR_NOT_FOUND);
    }
    vkDeviceWaitIdle(app_->device);
}

TEST_F(InteropSubmit, mistakesGetASentenceAndSubmitNothing) {
    OPEN_OR_SKIP({.multiview = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    const DplCamera views[2] = {frontCamera(kWidth, kHeight), frontCamera(kWidth, kHeight)};
    uint32_t made = 0;
    const auto refuses = [&](auto change, DplResult code, const char* text) {
        DplVulkanTarget desc = describe(image);
        change(desc);
        EXPECT_EQ(dplCreateVulkanTarget(context_, &desc, &made), code);
        EXPECT_TRUE(says(text)) << dplGetLastError();
    };
    refuses([](auto& d) { d.format = VK_FORMAT_R5G6B5_UNORM_PACK16; }, DPL_ERROR_UNSUPPORTED, "VkFormat 4");
    refuses([](auto& d) { d.samples = 2; }, DPL_ERROR_UNSUPPORTED, "2 samples");
    refuses([](auto& d) { d.viewMask = 3; }, DPL_ERROR_UNSUPPORTED, "multiview");
    refuses([](auto& d) { d.images[0] = VK_NULL_HANDLE; }, DPL_ERROR_INVALID_ARGUMENT, "image 0");
    refuses([](auto& d) { d.imageCount = 3; }, DPL_ERROR_INVALID_ARGUMENT, "3 images");
    refuses([](auto& d) { d.imageCount = 0; }, DPL_ERROR_INVALID_ARGUMENT, "0 images");
    refuses([](auto& d) { d.heightPx = 0; }, DPL_ERROR_INVALID_ARGUMENT, "x 0");
    refuses([](auto& d) { d.layoutBefore = VK_IMAGE_LAYOUT_UNDEFINED; }, DPL_ERROR_INVALID_ARGUMENT, "layoutBefore");
    EXPECT_EQ(dplCreateVulkanTarget(context_, nullptr, &made), DPL_ERROR_INVALID_ARGUMENT);

    made = targetOf(image);
    DplVulkanSubmission how{sizeof how};
    EXPECT_EQ(submit(4711, 0, {views, 1}, how), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(submit(made, 0, views, how), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("2 views")) << dplGetLastError();
    EXPECT_EQ(submit(made, DPL_VULKAN_SLOTS, {views, 1}, how), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("slot 3")) << dplGetLastError();
    EXPECT_EQ(dplVulkanSubmit(context_, made, 0, &avatar_, 1, views, 1, nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    const VkSemaphore none = VK_NULL_HANDLE;
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    how.waitCount = 1, how.waits = &none;
    EXPECT_EQ(submit(made, 0, {views, 1}, how), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("waitStages")) << dplGetLastError();
    how.waitStages = &stage;
    EXPECT_EQ(submit(made, 0, {views, 1}, how), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("wait 0")) << dplGetLastError();
    how.waitCount = 0, how.signalCount = 1;
    EXPECT_EQ(submit(made, 0, {views, 1}, how), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("signals")) << dplGetLastError();
    how.signals = &none;
    EXPECT_EQ(submit(made, 0, {views, 1}, how), DPL_ERROR_INVALID_ARGUMENT);
    how.signalCount = 0;
    how.fence = fence();
    ASSERT_EQ(submit(made, 0, {views, 1}, how), DPL_OK) << dplGetLastError();
    MUST(waitFor(how.fence));
}

}  // namespace
}  // namespace dpl::test
