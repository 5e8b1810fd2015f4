// SPDX-License-Identifier: Apache-2.0
// Vulkan runs out of memory, or loses the device, in every call that Doppel makes. Each failure becomes an error with a sentence; nothing
// leaks, nothing hangs, the validation layer stays silent, and the same call works once the cause is gone.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <future>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/interop/app_device.h"
#include "tests/unit/interop/failing_vulkan.h"

namespace dpl::test {
namespace {

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

TEST_F(VulkanFailures, aDeviceLostInAnyFunctionIsReplaced) {
    open();
    const DplCamera view = frontCamera(kSide, kSide);
    std::vector<uint8_t> rendered, pixels;
    const std::vector<uint8_t> framedBefore = framed(view);
    ASSERT_EQ(render(view, rendered), DPL_OK);
    struct Step {
        const char* name;
        std::function<DplResult()> run;
    };
    DplAvatar second = nullptr;
    const Step steps[] = {{"dplLoadAvatar", [&] { return dplLoadAvatar(context_, file_.data(), file_.size(), &second); }},
                          {"dplCreateVulkanComposer", [&] { return compose(); }},
                          {"dplVulkanPrepare", [&] { return frame(0, view); }},
                          {"dplRender", [&] { return render(view, pixels); }}};
    const auto replace = [&] {
        vulkan_.mend();
        program_.app->waitAll();
        ASSERT_EQ(rebuild(), DPL_OK) << dplGetLastError();
        const uint32_t gone = composer_;
        ASSERT_EQ(compose(), DPL_OK) << dplGetLastError();
        EXPECT_NE(composer_, gone) << "numbers are not used again";
        EXPECT_EQ(dplDestroyVulkanComposer(context_, gone), DPL_ERROR_NOT_FOUND);
    };
    size_t losses = 0;
    for (const Step& step : steps) {
        replace();
        vulkan_.failAt(0, VK_SUCCESS);
        ASSERT_EQ(step.run(), DPL_OK) << step.name << ": " << dplGetLastError();
        const std::vector<std::string> calls = vulkan_.calls();
        ASSERT_EQ(dplDestroyAvatar(std::exchange(second, nullptr)), DPL_OK);
        // The first call of each function that no step before lost the device in; of those that Vulkan lets tell of a loss, also the last.
        std::map<std::string, std::set<uint64_t>> places;
        for (size_t i = 0; i < calls.size(); ++i) {
            const bool tells = calls[i] == "vkQueueSubmit" || calls[i] == "vkWaitForFences" || calls[i] == "vkGetQueryPoolResults";
            std::set<uint64_t>& of = places[calls[i]];
            if (of.size() == 2) of.erase(std::prev(of.end()));
            if (tells || (of.empty() && !vulkan_.everFailed.contains(calls[i]))) of.insert(i + 1);
        }
        for (const auto& [function, numbers] : places)
            for (const uint64_t n : numbers) {
                replace();
                ++losses;
                vulkan_.failAt(n, VK_ERROR_DEVICE_LOST);
                const DplResult got = step.run();
                EXPECT_EQ(vulkan_.failed(), function);
                EXPECT_TRUE(got == DPL_OK || got == DPL_ERROR_DEVICE) << got << " from " << step.name << ", " << function;
                for (const Step& refused : steps) {
                    EXPECT_EQ(refused.run(), DPL_ERROR_DEVICE) << refused.name << " after " << function << " of " << step.name;
                    EXPECT_NE(std::string(dplGetLastError()).find("dplRebuildVulkan"), std::string::npos) << dplGetLastError();
                }
                ASSERT_EQ(dplDestroyAvatar(std::exchange(second, nullptr)), DPL_OK);
            }
    }
    std::printf("%zu losses\n", losses);
    replace();
    EXPECT_EQ(framed(view), framedBefore);
    ASSERT_EQ(render(view, pixels), DPL_OK);
    EXPECT_EQ(pixels, rendered);
}

TEST_F(VulkanFailures, theNewDeviceDrawsTheSamePictures) {
    open();
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.4, DPL_TRUE), DPL_OK);
    const DplDetail detail{sizeof detail, 0, 60};
    ASSERT_EQ(dplSetDetail(context_, &detail), DPL_OK);
    ASSERT_EQ(dplSetFrameBudget(context_, 1000), DPL_OK);
    const DplCamera view = frontCamera(kSide, kSide);
    std::vector<uint8_t> rendered, again;
    const std::vector<uint8_t> framedBefore = framed(view);
    ASSERT_EQ(render(view, rendered), DPL_OK);
    vulkan_.failAt(1, VK_ERROR_DEVICE_LOST);
    EXPECT_EQ(render(camera(3), again), DPL_ERROR_DEVICE);
    EXPECT_EQ(rebuild(), DPL_ERROR_DEVICE) << "this device is lost";
    EXPECT_EQ(render(view, again), DPL_ERROR_DEVICE);
    vulkan_.mend();

    Program lost = std::move(program_);
    std::string why;
    ASSERT_TRUE(openProgram(why)) << why;
    ASSERT_EQ(rebuild(), DPL_OK) << dplGetLastError();
    lost.close();
    ASSERT_EQ(compose(), DPL_OK) << dplGetLastError();
    EXPECT_EQ(framed(view), framedBefore);
    ASSERT_EQ(render(view, again), DPL_OK) << dplGetLastError();
    EXPECT_EQ(again, rendered);
    DplFrameStats stats{sizeof stats};
    ASSERT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK);
    EXPECT_LE(stats.splatsAllowed, detail.splatBudget);
    EXPECT_NE(stats.budgetState, DPL_BUDGET_OFF);
}

TEST_F(VulkanFailures, rebuildingAndDestroyingWaitForALoad) {
    open();
    const DplCamera view = frontCamera(kSide, kSide);
    std::vector<uint8_t> rendered, again;
    ASSERT_EQ(render(view, rendered), DPL_OK);
    for (const bool destroys : {false, true}) {
        struct Held {
            std::promise<void> reached, go;
        } held;
        dplSetLogCallback(
            [](void* user, DplLogLevel, const char* text) {
                if (std::string(text).find("prepared 'tiny'") != 0) return;
                static_cast<Held*>(user)->reached.set_value();
                static_cast<Held*>(user)->go.get_future().wait();
            },
            &held);
        DplAvatar second = nullptr;
        const auto loading = std::async(std::launch::async, [&] { return dplLoadAvatar(context_, file_.data(), file_.size(), &second); });
        held.reached.get_future().wait();
        auto replacing = std::async(std::launch::async, [&] { return destroys ? dplDestroyContext(context_) : rebuild(); });
        EXPECT_EQ(replacing.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
        held.go.set_value();
        EXPECT_EQ(replacing.get(), DPL_OK);
        loading.wait();
        dplSetLogCallback([](void*, DplLogLevel, const char*) {}, nullptr);
        ASSERT_NE(second, nullptr) << "the load has succeeded";
        EXPECT_EQ(dplDestroyAvatar(std::exchange(avatar_, second)), DPL_OK);
        if (destroys) {
            context_ = nullptr;
        } else {
            EXPECT_EQ(render(view, again), DPL_OK) << dplGetLastError();
            EXPECT_EQ(again, rendered);
        }
    }
}

TEST_F(VulkanFailures, aContextWithItsOwnDeviceIsRebuiltToo) {
    const DplContextInfo info{sizeof info, DPL_RENDERER_VULKAN, 1, 0, DPL_FILL_QUADS, nullptr};
    ASSERT_EQ(dplCreateContext(&info, &context_), DPL_OK) << dplGetLastError();
    ASSERT_EQ(load(), DPL_OK);
    const DplCamera view = frontCamera(kSide, kSide);
    std::vector<uint8_t> rendered, again;
    ASSERT_EQ(render(view, rendered), DPL_OK);
    EXPECT_EQ(rebuild(), DPL_ERROR_INVALID_ARGUMENT) << "the device is not the program's";
    ASSERT_EQ(dplRebuildVulkan(context_, nullptr), DPL_OK) << dplGetLastError();
    ASSERT_EQ(render(view, again), DPL_OK) << dplGetLastError();
    EXPECT_EQ(again, rendered);
    close();
    const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE, 1};
    ASSERT_EQ(dplCreateContext(&software, &context_), DPL_OK);
    EXPECT_EQ(dplRebuildVulkan(context_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(dplGetLastError()).find("CPU"), std::string::npos) << dplGetLastError();
    close();
    open();
    EXPECT_EQ(dplRebuildVulkan(context_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
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
