// SPDX-License-Identifier: Apache-2.0
// Loads in the background on a program's device: the program's frames carry the upload in slices. They submit, wait for and allocate
// nothing for it, and the avatar is the one of dplLoadAvatar.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "apps/bench/count_allocations.h"
#include "apps/bench/thread_time.h"
#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/api/background_load.h"
#include "tests/unit/interop/app_device.h"
#include "tests/unit/interop/failing_vulkan.h"

namespace dpl::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSide = 64;
constexpr uint32_t kSplats = 40000;    // 160 bytes each
constexpr uint32_t kFewestSlices = 6;  // of 1 MiB
constexpr float kUploadBegins = 0.7f;  // progress of a load

class InteropLoad : public testing::Test {
protected:
    /** The program, a context on its device and a tiny avatar in it. Skips the test where there is no Vulkan. plain: without validation
     *  and without counting calls, which allocate. */
    void open(bool plain = false) {
        plain_ = plain;
        vulkan_.mend();
        std::string why;
        app_ = AppDevice::open({.multiview = false, .validation = !plain}, why);
        if (!app_) GTEST_SKIP() << why;
        dplSetLogCallback([](void*, DplLogLevel, const char*) {}, nullptr);
        image_ = app_->makeTarget(kFormat, kSide, kSide);
        pass_ = app_->makePass(kFormat, 1, 0);
        framebuffer_ = app_->makeFramebuffer(pass_, {image_.layerViews[0]}, kSide, kSide);
        const DplVulkanDevice device = lent();
        const DplContextInfo info{sizeof info, DPL_RENDERER_AUTO, 1, 0, DPL_FILL_QUADS, nullptr};
        ASSERT_EQ(dplCreateVulkanContext(&device, &info, &context_), DPL_OK) << dplGetLastError();
        compose();
        const auto tiny = tinyFile();
        ASSERT_EQ(dplLoadAvatar(context_, tiny.data(), tiny.size(), &shown_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        dplSetLogCallback(nullptr, nullptr);
        if (!app_) return;
        app_->waitAll();
        EXPECT_EQ(dplDestroyAvatar(shown_), DPL_OK);
        EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        EXPECT_EQ(vulkan_.live(), 0u) << vulkan_.liveTypes();
        for (const std::string& mistake : vulkan_.mistakes()) ADD_FAILURE() << mistake;
        vkDestroyFramebuffer(app_->device, framebuffer_, nullptr);
        vkDestroyRenderPass(app_->device, pass_, nullptr);
        app_->destroy(image_);
        for (const std::string& message : app_->messages) ADD_FAILURE() << message;
    }
    DplVulkanDevice lent() const {
        DplVulkanDevice device{};
        device.structSize = sizeof device;
        if (!plain_) device.getInstanceProcAddr = vulkan_.entry();
        device.queueFamily = app_->family;
        device.instance = app_->instance, device.physicalDevice = app_->physical, device.device = app_->device, device.queue = app_->queue;
        device.enabledFeatures = &app_->enabled;
        return device;
    }
    void compose() {
        DplVulkanPass pass{};
        pass.structSize = sizeof pass;
        pass.renderPass = pass_, pass.colourFormat = kFormat;
        ASSERT_EQ(dplCreateVulkanComposer(context_, &pass, &composer_), DPL_OK) << dplGetLastError();
    }

    /** Starts a load and waits until it uploads. */
    void startUploading(BackgroundLoad& load, std::span<const uint8_t> bytes) {
        ASSERT_EQ(load.start(context_, bytes), DPL_OK) << dplGetLastError();
        ASSERT_TRUE(load.reaches(DPL_LOAD_UPLOADING));
    }

    /** What prepare did on the calling thread, summed up over frames. */
    struct Cost {
        uint64_t allocations = 0;               // of C++
        std::map<std::string, uint64_t> calls;  // of Vulkan, that can fail
        std::vector<double> ms;                 // of the thread, one a frame
        uint64_t count(const std::string& part) const {
            uint64_t sum = 0;
            for (const auto& [name, n] : calls) sum += name.find(part) != std::string::npos ? n : 0;
            return sum;
        }
    };
    /** A frame that shows an avatar. */
    void frame(uint32_t slot, DplAvatar avatar, Cost* cost = nullptr) {
        const DplCamera view = frontCamera(kSide, kSide);
        const VkCommandBuffer commands = app_->begin(slot);
        vulkan_.watchThread();
        const double start = threadMs();
        AllocationCount count(CountedThreads::Own);
        const DplResult prepared = dplVulkanPrepare(context_, commands, slot, &avatar, 1, &view, 1, nullptr);
        const uint64_t allocations = count.stop();
        const double ms = threadMs() - start;
        const auto calls = vulkan_.watchedCalls();
        EXPECT_EQ(prepared, DPL_OK) << dplGetLastError();
        if (cost) {
            cost->allocations += allocations, cost->ms.push_back(ms);
            for (const std::string& call : calls) ++cost->calls[call];
        }
        app_->barrier(commands, image_, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        begin.renderPass = pass_, begin.framebuffer = framebuffer_, begin.renderArea.extent = {kSide, kSide};
        vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        EXPECT_EQ(dplVulkanCompose(context_, composer_, commands, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
        vkCmdEndRenderPass(commands);
        app_->barrier(commands, image_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_->submit(slot);
    }
    /** A frame without avatars. */
    void emptyFrame(uint32_t slot) {
        const VkCommandBuffer commands = app_->begin(slot);
        EXPECT_EQ(dplVulkanUpload(context_, commands, slot), DPL_OK) << dplGetLastError();
        app_->submit(slot);
    }
    /** Calls next(slot) for frame after frame until the load is over, or has that progress. Returns how many frames that took. */
    template <class Frame>
    uint32_t framesUntil(float progress, BackgroundLoad& load, Frame next) {
        uint32_t frames = 0;
        EXPECT_TRUE(waitUntil([&] {
            if (load.state() >= DPL_LOAD_READY || load.progress >= progress) return true;
            next(frames++ % DPL_VULKAN_SLOTS);
            return false;
        }));
        return frames;
    }
    void emptyFramesUntilReady(BackgroundLoad& load) {
        framesUntil(1, load, [&](uint32_t slot) { emptyFrame(slot); });
    }
    std::vector<uint8_t> picture(DplAvatar avatar) {
        app_->upload(image_, 0, std::vector<uint8_t>(size_t(kSide) * kSide * 4));
        frame(0, avatar);
        return app_->download(image_, 0);
    }
    std::vector<uint8_t> pictureOfLoadAvatar(const std::vector<uint8_t>& bytes) {
        DplAvatar avatar = nullptr;
        EXPECT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
        std::vector<uint8_t> pixels = picture(avatar);
        EXPECT_GT(std::count_if(pixels.begin(), pixels.end(), [](uint8_t c) { return c > 20; }), 1000);
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
        return pixels;
    }
    DplAvatar finished(BackgroundLoad& load) {
        DplAvatar avatar = nullptr;
        EXPECT_EQ(dplFinishLoad(load.handle, &avatar), DPL_OK) << dplGetLastError();
        return avatar;
    }

    FailingVulkan& vulkan_ = failingVulkan();
    std::unique_ptr<AppDevice> app_;
    bool plain_ = false;
    AppImage image_;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
    DplContext context_ = nullptr;
    DplAvatar shown_ = nullptr;
    uint32_t composer_ = 0;
};

#define OPEN_OR_SKIP(...) \
    open(__VA_ARGS__);    \
    if (IsSkipped() || HasFatalFailure()) return

TEST_F(InteropLoad, framesCarryTheUploadAndDoNothingElseForIt) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(ball), tiny = picture(shown_);
    Cost without, with;
    for (uint32_t n = 0; n < 12; ++n) frame(n % DPL_VULKAN_SLOTS, shown_, n < 6 ? nullptr : &without);
    BackgroundLoad load;
    ASSERT_NO_FATAL_FAILURE(startUploading(load, ball));
    EXPECT_GE(framesUntil(1, load, [&](uint32_t slot) { frame(slot, shown_, &with); }), kFewestSlices);
    for (const auto& [name, count] : with.calls) EXPECT_TRUE(without.calls.count(name)) << name << ", " << count << " times";
    EXPECT_EQ(with.count("Submit") + with.count("Wait") + with.count("Create") + with.count("Allocate") + with.count("Map"), 0u);
    vulkan_.watchThread();
    const DplAvatar avatar = finished(load);
    EXPECT_TRUE(vulkan_.watchedCalls().empty()) << "a ready load is only handed over";
    Cost first;
    frame(0, avatar, &first);
    EXPECT_EQ(first.count("Submit") + first.count("WaitForFences"), 0u) << "the first frame makes what it needs, and does not wait";
    app_->waitAll();
    EXPECT_EQ(picture(avatar), expected);
    EXPECT_EQ(picture(shown_), tiny);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

TEST_F(InteropLoad, aFrameWithASliceAllocatesNothing) {
    OPEN_OR_SKIP(/*plain=*/true);
    Cost without, with;
    for (uint32_t n = 0; n < 60; ++n) frame(n % DPL_VULKAN_SLOTS, shown_, n < 6 ? nullptr : &without);
    BackgroundLoad load;
    const auto ball = ballOfSplats(4 * kSplats);
    ASSERT_NO_FATAL_FAILURE(startUploading(load, ball));
    framesUntil(1, load, [&](uint32_t slot) { frame(slot, shown_, &with); });
    EXPECT_EQ(without.allocations, 0u);
    EXPECT_EQ(with.allocations, 0u);
    EXPECT_GE(with.ms.size(), 4 * kFewestSlices);
    for (Cost* cost : {&without, &with}) std::sort(cost->ms.begin(), cost->ms.end());
    std::printf("prepare: %.3f ms of the calling thread (median of %zu), longest %.3f; while a load uploads: %.3f (of %zu), longest %.3f\n",
                without.ms[without.ms.size() / 2], without.ms.size(), without.ms.back(), with.ms[with.ms.size() / 2], with.ms.size(),
                with.ms.back());
    EXPECT_EQ(dplCancelLoad(load.handle), DPL_OK);
}

TEST_F(InteropLoad, aProgramThatDrawsNothingUploadsToo) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(ball);
    app_->waitAll();
    BackgroundLoad load;
    ASSERT_NO_FATAL_FAILURE(startUploading(load, ball));
    for (int i = 0; i < 30; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_EQ(load.state(), DPL_LOAD_UPLOADING) << "it waits for frames";
    }
    emptyFramesUntilReady(load);
    app_->waitAll();
    ASSERT_TRUE(load.reaches(DPL_LOAD_READY)) << "the GPU says when it has run the last copy; no further frame is needed";
    const DplAvatar avatar = finished(load);
    EXPECT_EQ(picture(avatar), expected);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    const VkCommandBuffer commands = app_->begin(0);
    EXPECT_EQ(dplVulkanUpload(context_, commands, DPL_VULKAN_SLOTS), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplVulkanUpload(context_, nullptr, 0), DPL_ERROR_INVALID_ARGUMENT);
    app_->submit(0);
}

TEST_F(InteropLoad, slicesOfDroppedCommandsAreRecordedAgain) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(ball);
    BackgroundLoad load;
    ASSERT_NO_FATAL_FAILURE(startUploading(load, ball));
    framesUntil(1, load, [&](uint32_t) {
        emptyFrame(0);
        const VkCommandBuffer dropped = app_->begin(1);
        ASSERT_EQ(dplVulkanUpload(context_, dropped, 1), DPL_OK) << dplGetLastError();
        ASSERT_EQ(vkResetCommandBuffer(dropped, 0), VK_SUCCESS);
        app_->begin(1), app_->submit(1);
        ASSERT_EQ(dplVulkanDropSlot(context_, 1), DPL_OK);
    });
    app_->waitAll();
    ASSERT_TRUE(load.reaches(DPL_LOAD_READY));
    const DplAvatar avatar = finished(load);
    EXPECT_EQ(picture(avatar), expected);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

TEST_F(InteropLoad, finishingEarlySubmitsTheRestWhateverTheCommandsHold) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(ball);
    BackgroundLoad load;
    ASSERT_NO_FATAL_FAILURE(startUploading(load, ball));
    framesUntil(kUploadBegins + 0.01f, load, [&](uint32_t) { emptyFrame(0); });
    const VkCommandBuffer open = app_->begin(1);
    ASSERT_EQ(dplVulkanUpload(context_, open, 1), DPL_OK) << dplGetLastError();
    const DplAvatar avatar = finished(load);  // while commands with slices are recorded and not submitted
    app_->submit(1);
    EXPECT_EQ(picture(avatar), expected);
    for (uint32_t n = 0; n < 4; ++n) frame(n % DPL_VULKAN_SLOTS, avatar);
    EXPECT_EQ(picture(avatar), expected);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

TEST_F(InteropLoad, cancelledAtAnyStageItLeavesNothing) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    const std::vector<uint8_t> tiny = picture(shown_);
    size_t objects = 0;
    for (int stage = 0; stage < 12; ++stage) {
        BackgroundLoad load;
        ASSERT_EQ(load.start(context_, ball), DPL_OK) << dplGetLastError();
        ASSERT_TRUE(load.reaches(stage == 0 ? DPL_LOAD_WAITING : stage == 1 ? DPL_LOAD_DECODING : DPL_LOAD_UPLOADING));
        if (stage > 2) framesUntil(kUploadBegins + 0.03f * float(stage - 2), load, [&](uint32_t slot) { emptyFrame(slot); });
        const VkCommandBuffer open = app_->begin(2);
        ASSERT_EQ(dplVulkanUpload(context_, open, 2), DPL_OK) << dplGetLastError();
        ASSERT_EQ(dplCancelLoad(load.handle), DPL_OK) << dplGetLastError();
        EXPECT_TRUE(load.isReleased());
        app_->submit(2);
        BackgroundLoad next;  // when it is ready, the cancelled one has gone
        const auto bytes = tinyFile();
        ASSERT_EQ(next.start(context_, bytes), DPL_OK);
        ASSERT_TRUE(next.reaches(DPL_LOAD_UPLOADING));
        emptyFramesUntilReady(next);
        ASSERT_TRUE(next.reaches(DPL_LOAD_READY));
        ASSERT_EQ(dplCancelLoad(next.handle), DPL_OK);
        for (uint32_t n = 0; n < 3 * DPL_VULKAN_SLOTS; ++n) emptyFrame(n % DPL_VULKAN_SLOTS);
        app_->waitAll();
        if (stage == 0) objects = vulkan_.live();
        EXPECT_EQ(vulkan_.live(), objects) << "stage " << stage << ": " << vulkan_.liveTypes();
    }
    EXPECT_EQ(picture(shown_), tiny);
}

TEST_F(InteropLoad, aContextMayGoWhileSlicesAreInFlight) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    BackgroundLoad load, waiting;
    ASSERT_EQ(load.start(context_, ball), DPL_OK) << dplGetLastError();
    ASSERT_EQ(waiting.start(context_, ball), DPL_OK) << dplGetLastError();
    ASSERT_TRUE(load.reaches(DPL_LOAD_UPLOADING));
    emptyFrame(0), emptyFrame(1);
    app_->waitAll();
    ASSERT_EQ(dplDestroyContext(std::exchange(context_, nullptr)), DPL_OK);
    EXPECT_EQ(load.state(), DPL_LOAD_FAILED);
    EXPECT_EQ(waiting.state(), DPL_LOAD_FAILED);
    EXPECT_EQ(waiting.released(), 1);
    EXPECT_EQ(dplCancelLoad(load.handle), DPL_OK);
    EXPECT_EQ(dplCancelLoad(waiting.handle), DPL_OK);
}

TEST_F(InteropLoad, aNewDeviceTakesOverWhatLoadsHaveBegun) {
    OPEN_OR_SKIP();
    const auto ball = ballOfSplats(kSplats);
    const std::vector<uint8_t> expected = pictureOfLoadAvatar(ball);
    BackgroundLoad uploading, decoding;
    ASSERT_EQ(uploading.start(context_, ball), DPL_OK) << dplGetLastError();
    ASSERT_EQ(decoding.start(context_, ball), DPL_OK) << dplGetLastError();
    ASSERT_TRUE(uploading.reaches(DPL_LOAD_UPLOADING));
    emptyFrame(0), emptyFrame(1);
    app_->waitAll();
    vulkan_.failAt(1, VK_ERROR_DEVICE_LOST);
    std::vector<uint8_t> pixels(size_t(kSide) * kSide * 4);
    const DplImage image{sizeof image, 0, pixels.data(), pixels.size(), 0, nullptr, 0};
    const DplCamera view = frontCamera(16, 16);
    EXPECT_EQ(dplRender(context_, shown_, &view, 1, &image), DPL_ERROR_DEVICE);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    EXPECT_EQ(uploading.state(), DPL_LOAD_UPLOADING) << "a load waits for the new device";
    vulkan_.mend();
    const DplVulkanDevice device = lent();  // as good as new
    ASSERT_EQ(dplRebuildVulkan(context_, &device), DPL_OK) << dplGetLastError();
    compose();
    ASSERT_TRUE(uploading.reaches(DPL_LOAD_READY));
    const DplAvatar first = finished(uploading);
    EXPECT_EQ(picture(first), expected);
    emptyFramesUntilReady(decoding);
    const DplAvatar second = finished(decoding);
    EXPECT_EQ(picture(second), expected);
    EXPECT_EQ(dplDestroyAvatar(first), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(second), DPL_OK);
}

}  // namespace
}  // namespace dpl::test
