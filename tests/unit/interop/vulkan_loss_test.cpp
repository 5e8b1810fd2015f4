// SPDX-License-Identifier: Apache-2.0
// Vulkan loses the device in every call that Doppel makes. Avatars stay, one call rebuilds what the GPU held, and the pictures are the
// same.
#include <chrono>
#include <cstdio>
#include <functional>
#include <future>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "tests/unit/interop/vulkan_failures.h"

namespace dpl::test {
namespace {

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

}  // namespace
}  // namespace dpl::test
