// SPDX-License-Identifier: Apache-2.0
// Vulkan runs out of memory in every call that Doppel makes. Each failure becomes an error with a sentence; nothing leaks, nothing hangs,
// the validation layer stays silent, and the same call works once the cause is gone.
#include <utility>

#include "tests/unit/interop/vulkan_failures.h"

namespace dpl::test {
namespace {

TEST_F(VulkanFailures, creatingRunsOutOfMemory) {
    const Sweep contexts = sweep(
        [&](uint64_t) {
            const DplResult got = create();
            EXPECT_TRUE(got == DPL_OK || vulkan_.live() == 0) << vulkan_.failed() << " leaks " << vulkan_.liveTypes();
            return got;
        },
        [&](uint64_t) { close(); });
    print("contexts", contexts);
    EXPECT_GT(contexts.failed, 20u);

    ASSERT_EQ(create(), DPL_OK);
    const size_t before = vulkan_.live();
    const auto leaks = [&](DplResult got) {
        EXPECT_TRUE(got == DPL_OK || vulkan_.live() == before) << vulkan_.failed() << " leaks";
        return got;
    };
    const Sweep composers = sweep([&](uint64_t) { return leaks(compose()); },
                                  [&](uint64_t) { EXPECT_EQ(dplDestroyVulkanComposer(context_, composer_), DPL_OK); });
    print("composers", composers);
    EXPECT_EQ(composers.failed, 3u);
    const Sweep targets = sweep([&](uint64_t) { return leaks(makeTarget()); },
                                [&](uint64_t) { EXPECT_EQ(dplDestroyVulkanTarget(context_, target_), DPL_OK); });
    print("targets", targets);
    EXPECT_EQ(targets.failed, 5u) << "a pass, a framebuffer and a composer";
    uint64_t leaner = 0;
    const Sweep avatars = sweep([&](uint64_t) { return leaks(load()); },
                                [&](uint64_t) {
                                    leaner += isLean(avatar_);
                                    EXPECT_EQ(dplDestroyAvatar(std::exchange(avatar_, nullptr)), DPL_OK);
                                });
    print("avatars", avatars);
    EXPECT_EQ(avatars.failed, 0u) << "what does not fit is loaded with less";
    EXPECT_GT(leaner, 40u);
    EXPECT_EQ(vulkan_.live(), before);
}

class VulkanFailuresOfFill : public VulkanFailures, public testing::WithParamInterface<DplFill> {};
INSTANTIATE_TEST_SUITE_P(Fills, VulkanFailuresOfFill, testing::Values(DPL_FILL_QUADS, DPL_FILL_TILES),
                         [](const auto& info) { return info.param == DPL_FILL_TILES ? "Tiles" : "Quads"; });

TEST_P(VulkanFailuresOfFill, framesOfNewSizesRunOutOfMemory) {
    open(GetParam());
    const DplCamera view = frontCamera(kSide, kSide);
    std::vector<uint8_t> rendered, again;
    const std::vector<uint8_t> framedBefore = framed(view);
    ASSERT_EQ(render(view, rendered), DPL_OK);
    close();

    open(GetParam());  // anew, so that pipelines are missing too
    const Sweep frames = sweep([&](uint64_t n) { return frame(uint32_t(n % DPL_VULKAN_SLOTS), camera(uint32_t(n))); }, [](uint64_t) {});
    print("prepare and compose", frames);
    EXPECT_GT(frames.failed, 100u);
    std::vector<uint8_t> pixels;
    const Sweep renders = sweep([&](uint64_t n) { return render(camera(uint32_t(n)), pixels); },
                                [&](uint64_t n) {
                                    std::vector<uint8_t> whole;
                                    ASSERT_EQ(render(camera(uint32_t(n)), whole), DPL_OK) << dplGetLastError();
                                    EXPECT_EQ(pixels, whole) << "a call that succeeded has drawn";
                                });
    print("dplRender", renders);
    EXPECT_GT(renders.failed, 100u);
    EXPECT_EQ(framed(view), framedBefore) << "the same picture as if nothing had failed";
    ASSERT_EQ(render(view, again), DPL_OK);
    EXPECT_EQ(again, rendered);
}

TEST_F(VulkanFailures, submissionsRunOutOfMemoryAndLeaveAUsableState) {
    open();
    ASSERT_EQ(makeTarget(), DPL_OK) << dplGetLastError();
    const DplCamera view = frontCamera(kSide, kSide);
    const std::vector<uint8_t> expected = framed(view);
    EXPECT_EQ(submitted(view), expected);
    const Sweep submissions =
        sweep([&](uint64_t n) { return submit(uint32_t(n % DPL_VULKAN_SLOTS), camera(uint32_t(n))); }, [](uint64_t) {});
    print("submissions of new sizes", submissions);
    EXPECT_GT(submissions.failed, 100u);
    for (const char* function : {"vkResetCommandBuffer", "vkBeginCommandBuffer", "vkEndCommandBuffer", "vkQueueSubmit"}) {
        program_.app->upload(program_.image, 0, std::vector<uint8_t>(expected.size()));
        vulkan_.failAt(1, VK_ERROR_OUT_OF_HOST_MEMORY, function);
        EXPECT_EQ(submit(0, view), DPL_ERROR_OUT_OF_MEMORY) << function;
        EXPECT_EQ(vulkan_.failed(), function);
        vulkan_.mend();
        EXPECT_EQ(program_.app->download(program_.image, 0), std::vector<uint8_t>(expected.size())) << "nothing was submitted";
        EXPECT_EQ(submitted(view), expected) << "with the same slot, after " << function;
    }
    vulkan_.failAt(1, VK_ERROR_DEVICE_LOST, "vkQueueSubmit");
    EXPECT_EQ(submit(0, view), DPL_ERROR_DEVICE);
    EXPECT_EQ(makeTarget(), DPL_ERROR_DEVICE);
    vulkan_.mend();
    ASSERT_EQ(rebuild(), DPL_OK) << dplGetLastError();
    EXPECT_EQ(submit(0, view), DPL_ERROR_NOT_FOUND) << "targets are made anew";
    ASSERT_EQ(makeTarget(), DPL_OK) << dplGetLastError();
    EXPECT_EQ(submitted(view), expected);
}

TEST_F(VulkanFailures, everyFunctionFailsOnceInAFreshContext) {
    const DplCamera view = frontCamera(kSide, kSide);
    std::vector<uint8_t> pixels;
    const auto drawAll = [&] {
        DplResult result = frame(0, view);
        if (result == DPL_OK && (result = makeTarget()) == DPL_OK) {
            result = submit(1, view);
            EXPECT_EQ(dplDestroyVulkanTarget(context_, target_), DPL_OK);
        }
        for (int i = 0; i < 5 && result == DPL_OK; ++i) result = dplDraw(context_, avatar_, &view, 1, 0);
        return result == DPL_OK ? render(view, pixels) : result;
    };
    open();
    ASSERT_EQ(drawAll(), DPL_OK);
    const std::vector<uint8_t> expected = pixels;
    close();
    for (const std::string& function : std::set(vulkan_.everCalled)) {
        open();
        vulkan_.failAt(1, VK_ERROR_OUT_OF_HOST_MEMORY, function);
        const DplResult got = drawAll();
        EXPECT_TRUE(got == DPL_ERROR_OUT_OF_MEMORY || (got == DPL_OK && pixels == expected)) << got << " after " << function;
        vulkan_.mend();
        EXPECT_EQ(drawAll(), DPL_OK) << function << ": " << dplGetLastError();
        EXPECT_EQ(pixels, expected) << function;
        close();
    }
    EXPECT_EQ(vulkan_.everFailed, vulkan_.everCalled);
}

TEST_F(VulkanFailures, theProgramsAllocatorRunsOutOfMemory) {
    allocator_ = std::make_unique<FailingAllocator>();
    const auto nothingIsLeft = [&] { EXPECT_EQ(allocator_->live(), 0u) << "allocations of the driver"; };
    const Sweep contexts = sweep(
        [&](uint64_t) {
            const DplResult got = create();
            if (got != DPL_OK) nothingIsLeft();
            return got;
        },
        [&](uint64_t) { close(); });
    print("contexts", contexts);
    EXPECT_GT(contexts.failed, 5u);
    open();
    DplAvatar second = nullptr;
    uint64_t leaner = 0;
    const Sweep avatars = sweep([&](uint64_t) { return dplLoadAvatar(context_, file_.data(), file_.size(), &second); },
                                [&](uint64_t) {
                                    leaner += isLean(second);
                                    EXPECT_EQ(dplDestroyAvatar(std::exchange(second, nullptr)), DPL_OK);
                                });
    print("avatars", avatars);
    EXPECT_GT(leaner, 10u);
    const Sweep frames = sweep([&](uint64_t n) { return frame(uint32_t(n % DPL_VULKAN_SLOTS), camera(uint32_t(n))); }, [](uint64_t) {});
    print("prepare and compose", frames);
    EXPECT_GT(frames.failed, 20u);
    const std::vector<uint8_t> picture = framed(frontCamera(kSide, kSide));
    close();
    nothingIsLeft();
    allocator_.reset();
    open();
    EXPECT_EQ(framed(frontCamera(kSide, kSide)), picture);
}

TEST_F(VulkanFailures, aSlotThatComesTooEarlyIsNoticed) {
    open();
    AppDevice& app = *program_.app;
    const DplCamera view = frontCamera(kSide, kSide);
    const std::vector<uint8_t> picture = framed(view);
    const auto prepare = [&](VkCommandBuffer commands, uint32_t slot) {
        return dplVulkanPrepare(context_, commands, slot, &avatar_, 1, &view, 1, nullptr);
    };
    const auto saysEarly = [] { return std::string(dplGetLastError()).find("slot 1 is prepared again") != std::string::npos; };

    // Commands that were recorded and never submitted.
    VkCommandBuffer commands = app.begin(1);
    ASSERT_EQ(prepare(commands, 1), DPL_OK) << dplGetLastError();
    ASSERT_EQ(vkResetCommandBuffer(commands, 0), VK_SUCCESS);
    commands = app.begin(1);
    EXPECT_EQ(prepare(commands, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(saysEarly()) << dplGetLastError();
    EXPECT_EQ(framed(view), picture) << "other slots go on";
    ASSERT_EQ(dplVulkanDropSlot(context_, 1), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplVulkanCompose(context_, composer_, commands, 1, 0, 0, 0), DPL_ERROR_INVALID_ARGUMENT) << "the slot is empty";
    EXPECT_EQ(dplVulkanDropSlot(context_, DPL_VULKAN_SLOTS), DPL_ERROR_INVALID_ARGUMENT);
    app.submit(1);

    // Commands that the GPU holds back.
    VkEventCreateInfo info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
    VkEvent go = VK_NULL_HANDLE;
    ASSERT_EQ(vkCreateEvent(app.device, &info, nullptr, &go), VK_SUCCESS);
    commands = app.begin(1);
    vkCmdWaitEvents(commands, 1, &go, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, nullptr, 0, nullptr, 0, nullptr);
    ASSERT_EQ(prepare(commands, 1), DPL_OK) << dplGetLastError();
    app.submit(1);
    EXPECT_EQ(prepare(app.begin(2), 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(saysEarly()) << dplGetLastError();
    ASSERT_EQ(vkSetEvent(app.device, go), VK_SUCCESS);
    app.submit(2);
    app.waitAll();
    EXPECT_EQ(prepare(app.begin(1), 1), DPL_OK) << dplGetLastError();
    app.submit(1);
    app.waitAll();
    vkDestroyEvent(app.device, go, nullptr);
    for (uint64_t n = 0; n < 3 * DPL_VULKAN_SLOTS; ++n) ASSERT_EQ(frame(uint32_t(n % DPL_VULKAN_SLOTS), view), DPL_OK) << lastError_;
    EXPECT_EQ(framed(view), picture);
}

TEST_F(VulkanFailures, destroyingRunsOutOfMemory) {
    for (uint64_t n = 1; n < 20; ++n) {
        if (!context_) open();
        const DplCamera view = camera(1);
        for (uint32_t i = 0; i < 3; ++i) ASSERT_EQ(dplDraw(context_, avatar_, &view, 1, 0), DPL_OK);  // they run while the context goes
        ASSERT_EQ(frame(0, view), DPL_OK);
        program_.app->waitAll();
        vulkan_.failAt(n, VK_ERROR_OUT_OF_HOST_MEMORY);
        close();
        const bool met = !vulkan_.failed().empty();
        vulkan_.mend();
        if (!met) return;
    }
    ADD_FAILURE() << "the sweep does not end";
}

}  // namespace
}  // namespace dpl::test
