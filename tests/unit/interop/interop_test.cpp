// SPDX-License-Identifier: Apache-2.0
// Avatars in a program's own Vulkan frames: the same pixels as dplRender composes, in every format and kind of pass, without a submission,
// a wait or an allocation of Doppel's, and with the validation layer silent.
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/bench/count_allocations.h"
#include "apps/bench/thread_time.h"
#include "tests/unit/interop/interop_fixture.h"

namespace dpl::test {
namespace {

struct FormatCase {
    const char* name;
    VkFormat format;
};
constexpr FormatCase kFormats[] = {{"RGBA8", VK_FORMAT_R8G8B8A8_UNORM},        {"BGRA8", VK_FORMAT_B8G8R8A8_UNORM},
                                   {"RGBA8 sRGB", VK_FORMAT_R8G8B8A8_SRGB},    {"BGRA8 sRGB", VK_FORMAT_B8G8R8A8_SRGB},
                                   {"RGBA16F", VK_FORMAT_R16G16B16A16_SFLOAT}, {"A2B10G10R10", VK_FORMAT_A2B10G10R10_UNORM_PACK32}};
class InteropFormats : public Interop, public testing::WithParamInterface<std::tuple<DplFill, bool>> {};
INSTANTIATE_TEST_SUITE_P(Ways, InteropFormats, testing::Combine(testing::Values(DPL_FILL_QUADS, DPL_FILL_TILES), testing::Bool()),
                         [](const auto& info) {
                             return std::string(std::get<0>(info.param) == DPL_FILL_TILES ? "Tiles" : "Quads") +
                                    (std::get<1>(info.param) ? "DynamicRendering" : "RenderPass");
                         });

TEST_P(InteropFormats, composesWhatTheRefereeComposes) {
    const auto [fill, dynamic] = GetParam();
    OPEN_OR_SKIP({.multiview = false, .dynamicRendering = dynamic}, fill);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const std::vector<uint8_t> layer = layerOf(camera), cpuLayer = layerOfTheCpu(camera);
    uint32_t slot = 0;
    for (const auto [name, format] : kFormats) {
        SCOPED_TRACE(name);
        const AppImage& image = target(format);
        const std::vector<uint8_t> under = background(format);
        app_->upload(image, 0, under);
        const Passes passes = passesFor(image, dynamic);
        ASSERT_EQ(frame(slot++ % DPL_VULKAN_SLOTS, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
        const std::vector<uint8_t> drawn = app_->download(image, 0);
        std::vector<uint8_t> expected = under, endToEnd = under;
        reference::compose(refereeFormat(format), layer, expected);
        reference::compose(refereeFormat(format), cpuLayer, endToEnd);

        const double db = psnrDb(drawn, expected, format), endToEndDb = psnrDb(drawn, endToEnd, format);
        std::printf("%s: %.1f dB with the picture of the GPU, %.1f dB with that of the CPU\n", name, db, endToEndDb);
        EXPECT_GT(db, 60);
        EXPECT_GT(endToEndDb, 50);
        const size_t bytes = reference::bytesOf(refereeFormat(format));
        size_t empty = 0;
        for (size_t i = 0; i < layer.size() / 4; ++i) {
            if (layer[4 * i + 3] == 0) {
                ++empty;
                ASSERT_EQ(std::memcmp(&drawn[i * bytes], &under[i * bytes], bytes), 0)
                    << "an empty pixel of the picture changed the target";
            }
            if (layer[4 * i + 3] != 255 || bytes == 8 || format == VK_FORMAT_A2B10G10R10_UNORM_PACK32) continue;
            ASSERT_TRUE(mayGive(format, fill, &layer[4 * i], reference::unpack(refereeFormat(format), &under[4 * i]),
                                reference::unpack(refereeFormat(format), &drawn[4 * i])))
                << "an opaque pixel is the picture's";
            ASSERT_NEAR(drawn[4 * i + 3], expected[4 * i + 3], 1);
        }
        EXPECT_GT(empty, 1000u);
        EXPECT_LT(empty, layer.size() / 4 - 500) << "the avatar covers pixels";
        EXPECT_NE(drawn, under);
    }
}

class InteropStereo : public Interop, public testing::WithParamInterface<std::tuple<bool, DplFill>> {};
INSTANTIATE_TEST_SUITE_P(Ways, InteropStereo, testing::Combine(testing::Bool(), testing::Values(DPL_FILL_QUADS, DPL_FILL_TILES)),
                         [](const auto& info) {
                             return std::string(std::get<0>(info.param) ? "Multiview" : "AnImageAnEye") +
                                    (std::get<1>(info.param) == DPL_FILL_TILES ? "Tiles" : "Quads");
                         });

TEST_P(InteropStereo, bothEyesGetTheirPicture) {
    const auto [multiview, fill] = GetParam();
    OPEN_OR_SKIP({.multiview = multiview}, fill);
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_SRGB;
    const AppImage& image = target(kFormat, 2);
    const std::vector<uint8_t> under = background(kFormat);
    if (multiview && !canMask()) GTEST_SKIP() << dplGetLastError();
    const Passes passes = passesFor(image, false, multiview ? 3 : 0);
    for (const bool canted : {false, true}) {
        DplCamera eyes[2] = {frontCamera(kWidth, kHeight, 0.03f), frontCamera(kWidth, kHeight, -0.03f)};
        if (canted) cant(eyes[1]);
        app_->upload(image, 0, under), app_->upload(image, 1, under);
        ASSERT_EQ(frame(canted, image, passes, {&avatar_, 1}, eyes), DPL_OK) << dplGetLastError();
        for (uint32_t eye = 0; eye < 2; ++eye) {
            const auto drawn = app_->download(image, eye), expected = composed(eyes[eye], kFormat, under);
            const double db = psnrDb(drawn, expected, kFormat), other = psnrDb(drawn, composed(eyes[1 - eye], kFormat, under), kFormat);
            std::printf("%s, eye %u: %.1f dB (the other eye's: %.1f)\n", canted ? "canted" : "parallel", eye, db, other);
            EXPECT_GT(db, 50);
            EXPECT_LT(other, db - 10) << "the eyes differ";
        }
    }
}

struct DepthCase {
    const char* name;
    VkFormat format;
    float scale, offset;  // stored depth = scale + offset / z
    float clear;          // stored where there is no scene
};
constexpr DepthCase kConventions[] = {{"usual", VK_FORMAT_D32_SFLOAT, kFar / (kFar - kNear), -kFar* kNear / (kFar - kNear), 1},
                                      {"usual, D16", VK_FORMAT_D16_UNORM, kFar / (kFar - kNear), -kFar* kNear / (kFar - kNear), 1},
                                      {"usual infinite", VK_FORMAT_D32_SFLOAT, 1, -kNear, 1},
                                      {"reversed", VK_FORMAT_D32_SFLOAT, -kNear / (kFar - kNear), kFar* kNear / (kFar - kNear), 0},
                                      {"reversed infinite", VK_FORMAT_D32_SFLOAT, 0, kNear, 0}};
class InteropDepth : public Interop, public testing::WithParamInterface<DplFill> {};
INSTANTIATE_TEST_SUITE_P(Fills, InteropDepth, testing::Values(DPL_FILL_QUADS, DPL_FILL_TILES),
                         [](const auto& info) { return std::string(info.param == DPL_FILL_TILES ? "Tiles" : "Quads"); });

TEST_P(InteropDepth, hidesWhatLiesBehindTheScene) {
    OPEN_OR_SKIP({.multiview = false}, GetParam());
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    // A wall in front of the left half of the avatar's middle, nothing elsewhere; the image is larger than the view.
    constexpr int32_t kX = 11, kY = 5;
    constexpr uint32_t kImageWidth = kWidth + 30, kImageHeight = kHeight + 9;
    constexpr float kWallM = 1.5f;
    const AppImage& image = target(kFormat, 2);
    const std::vector<uint8_t> under = background(kFormat);
    const Passes passes = passesFor(image, false);
    for (const DepthCase& convention : kConventions) {
        DplCamera eyes[2] = {frontCamera(kWidth, kHeight, 0.03f), frontCamera(kWidth, kHeight, -0.03f)};
        std::vector<std::vector<float>> stored(2, std::vector<float>(kImageWidth * kImageHeight, convention.clear));
        std::vector<std::vector<float>> scene(2, std::vector<float>(kWidth * kHeight));
        for (uint32_t eye = 0; eye < 2; ++eye)
            for (uint32_t y = 0; y < kHeight; ++y)
                for (uint32_t x = 0; x < kWidth / 2 + 5 * eye; ++x) {
                    if (y < 20 || y > 50) continue;
                    scene[eye][y * kWidth + x] = kWallM;
                    stored[eye][(y + kY) * kImageWidth + x + kX] = convention.scale + convention.offset / kWallM;
                }
        images_.push_back(app_->makeDepth(convention.format, kImageWidth, kImageHeight, stored));
        const AppImage& depth = images_.back();
        DplVulkanSceneDepth depths[2]{};
        for (uint32_t eye = 0; eye < 2; ++eye)
            depths[eye] = {
                sizeof depths[eye], eye, depth.view, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, 1, kX, kY, convention.scale,
                convention.offset};
        app_->upload(image, 0, under), app_->upload(image, 1, under);
        ASSERT_EQ(frame(0, image, passes, {&avatar_, 1}, eyes, {0, 0}, depths), DPL_OK) << dplGetLastError();
        for (uint32_t eye = 0; eye < 2; ++eye) {
            const auto whole = composed(eyes[eye], kFormat, under);
            eyes[eye].sceneDepthM = scene[eye].data(), eyes[eye].sceneDepthCount = scene[eye].size();
            const auto drawn = app_->download(image, eye), expected = composed(eyes[eye], kFormat, under);
            const double db = psnrDb(drawn, expected, kFormat), without = psnrDb(whole, expected, kFormat);
            std::printf("%s, eye %u: %.1f dB (without the wall %.1f)\n", convention.name, eye, db, without);
            EXPECT_GT(db, 60);
            EXPECT_LT(without, 45) << "the wall hides something";
        }
    }
}

TEST_F(Interop, depthOfFourSamplesHidesToo) {
    OPEN_OR_SKIP({.multiview = false});
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    const AppImage& image = target(kFormat);
    const Passes passes = passesFor(image, false);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const std::vector<uint8_t> under = background(kFormat);
    for (const float wallM : {1.0f, 30.0f}) {  // the avatar stands 3 m away
        images_.push_back(app_->makeFourSampleDepth(kWidth, kHeight, kNear / wallM));
        const DplVulkanSceneDepth depth{sizeof depth, 0, images_.back().view, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, 4, 0, 0, 0,
                                        kNear};
        app_->upload(image, 0, under);
        ASSERT_EQ(frame(0, image, passes, {&avatar_, 1}, {&camera, 1}, {0, 0}, &depth), DPL_OK) << dplGetLastError();
        const auto drawn = app_->download(image, 0);
        if (wallM < 2)
            EXPECT_EQ(drawn, under) << "all is hidden";
        else
            EXPECT_GT(psnrDb(drawn, composed(camera, kFormat, under), kFormat), 60);
    }
}

TEST_F(Interop, aPictureMayLieAnywhereInTheTarget) {
    OPEN_OR_SKIP({.multiview = false});
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const AppImage& image = target(kFormat, 1, 1, 2 * kWidth, 2 * kHeight);
    const Passes passes = passesFor(image, false);
    const std::vector<uint8_t> layer = layerOf(camera), empty(size_t(image.width) * image.height * 4);
    for (const VkOffset2D at : {VkOffset2D{37, 21}, VkOffset2D{-30, -15}, VkOffset2D{int32_t(image.width) - 40, 60}}) {
        app_->upload(image, 0, empty);
        ASSERT_EQ(frame(0, image, passes, {&avatar_, 1}, {&camera, 1}, at), DPL_OK) << dplGetLastError();
        const auto drawn = app_->download(image, 0);
        size_t wrong = 0, seen = 0;
        for (int32_t y = 0; y < int32_t(image.height); ++y)
            for (int32_t x = 0; x < int32_t(image.width); ++x) {
                const int32_t px = x - at.x, py = y - at.y;
                const bool inside = px >= 0 && py >= 0 && px < int32_t(kWidth) && py < int32_t(kHeight);
                const uint8_t* from = inside ? &layer[(size_t(py) * kWidth + size_t(px)) * 4] : nullptr;
                const uint8_t* to = &drawn[(size_t(y) * image.width + size_t(x)) * 4];
                for (int c = 0; c < 4; ++c) wrong += std::abs(int(to[c]) - (from ? from[c] : 0)) > 1;
                seen += to[3] != 0;
            }
        EXPECT_EQ(wrong, 0u) << at.x << ", " << at.y;
        EXPECT_GT(seen, 300u);
    }
}

TEST_F(Interop, slotsInFlightKeepTheirPoses) {
    OPEN_OR_SKIP({.multiview = false});
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    const DplCamera camera = frontCamera(kWidth, kHeight);
    std::vector<Passes> passes;
    std::vector<size_t> targets;
    const std::vector<uint8_t> under = background(kFormat);
    for (uint32_t slot = 0; slot < DPL_VULKAN_SLOTS; ++slot) {
        target(kFormat), targets.push_back(images_.size() - 1);
        passes.push_back(passesFor(images_.back(), false));
    }
    std::vector<uint8_t> last;
    for (uint32_t round = 0; round < 4; ++round) {
        for (size_t t : targets) app_->upload(images_[t], 0, under);
        for (uint32_t slot = 0; slot < DPL_VULKAN_SLOTS; ++slot) {  // nobody waits between them
            ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.13 * (round * DPL_VULKAN_SLOTS + slot), DPL_TRUE), DPL_OK);
            ASSERT_EQ(frame(slot, images_[targets[slot]], passes[slot], {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
        }
        app_->waitAll();
        for (uint32_t slot = 0; slot < DPL_VULKAN_SLOTS; ++slot) {
            ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.13 * (round * DPL_VULKAN_SLOTS + slot), DPL_TRUE), DPL_OK);
            const auto drawn = app_->download(images_[targets[slot]], 0);
            EXPECT_GT(psnrDb(drawn, composed(camera, kFormat, under), kFormat), 60) << "round " << round << ", slot " << slot;
            EXPECT_NE(drawn, last) << "the pose changes";
            last = drawn;
        }
    }
}

TEST_F(Interop, sizesChangeAndAvatarsGoWhileFramesAreInFlight) {
    OPEN_OR_SKIP({.multiview = false});
    constexpr VkFormat kFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
    const AppImage& image = target(kFormat);
    const Passes passes = passesFor(image, false);
    const auto bytes = tinyFile();
    for (uint32_t n = 0; n < 24; ++n) {  // more sizes and avatars than the caches keep
        const uint32_t slot = n % DPL_VULKAN_SLOTS;
        const DplCamera camera = frontCamera(kWidth - n, kHeight - n / 2);
        DplAvatar second = nullptr;
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &second), DPL_OK) << dplGetLastError();
        const DplAvatar both[2] = {avatar_, second};
        ASSERT_EQ(frame(slot, image, passes, both, {&camera, 1}), DPL_OK) << dplGetLastError();
        ASSERT_EQ(dplDestroyAvatar(second), DPL_OK);
        const uint32_t composer = composerFor(passes.pass, kFormat);
        ASSERT_EQ(dplDestroyVulkanComposer(context_, composer), DPL_OK);
    }
    DplFrameStats stats{sizeof stats};
    ASSERT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK);
    EXPECT_LT(stats.residentBytes, 64u << 20) << "what is no longer used is freed";
}

TEST_F(Interop, detailAndFrameBudgetHoldInTheProgramsFrames) {
    OPEN_OR_SKIP({.multiview = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    const Passes passes = passesFor(image, false);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    uint32_t count = 0;
    const auto draw = [&](int frames) {
        DplFrameStats stats{sizeof stats};
        for (int n = 0; n < frames; ++n) {
            EXPECT_EQ(frame(count++ % DPL_VULKAN_SLOTS, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
            stats = {sizeof stats};
            EXPECT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK) << dplGetLastError();
        }
        return stats;
    };
    EXPECT_EQ(draw(3).frameMs, 0) << "no slot came round";
    const DplFrameStats all = draw(1);
    if (all.frameMs == 0) GTEST_SKIP() << "the device has no timestamps";
    EXPECT_EQ(all.keptWanted, all.splatsAllowed);
    const DplDetail detail{sizeof detail, 0, all.keptWanted / 2};
    ASSERT_EQ(dplSetDetail(context_, &detail), DPL_OK);
    const DplFrameStats half = draw(3);
    EXPECT_LE(half.splatsAllowed, detail.splatBudget);
    EXPECT_EQ(half.budgetState, DPL_BUDGET_OFF);
    ASSERT_EQ(dplSetFrameBudget(context_, 1e-6), DPL_OK);
    const DplFrameStats least = draw(60);
    EXPECT_EQ(least.budgetState, DPL_BUDGET_UNREACHABLE);
    EXPECT_LT(least.splatsAllowed, half.splatsAllowed / 4);
    EXPECT_GE(least.framesOver, 55u);
}

TEST_F(Interop, countsAndPassTimesAreThoseOfTheLastFrameThatIsKnownToHaveFinished) {
    OPEN_OR_SKIP({.multiview = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    const Passes passes = passesFor(image, false);
    const DplCamera near = frontCamera(kWidth, kHeight), away = frontCamera(kWidth, kHeight, 50);
    uint32_t count = 0;
    const auto draw = [&](const DplCamera& camera) {
        EXPECT_EQ(frame(count++ % DPL_VULKAN_SLOTS, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
        DplFrameStats stats{sizeof stats};
        EXPECT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK) << dplGetLastError();
        return stats;
    };
    for (uint32_t n = 0; n < DPL_VULKAN_SLOTS; ++n) EXPECT_EQ(draw(near).splatsDrawn, 0u) << "no slot came round";
    const DplFrameStats stats = draw(near);
    EXPECT_GT(stats.splatsDrawn, 100u);
    EXPECT_EQ(stats.viewCount, 1u);
    double sumMs = 0;
    for (uint32_t i = 0; i < stats.passCount; ++i) {
        DplPassTime pass{sizeof pass};
        ASSERT_EQ(dplGetPassTime(avatar_, i, &pass), DPL_OK) << dplGetLastError();
        EXPECT_NE(pass.label, nullptr);
        sumMs += pass.milliseconds;
    }
    EXPECT_NEAR(sumMs, stats.frameMs, 1e-6);
    EXPECT_TRUE(stats.passCount > 3 || stats.frameMs == 0) << stats.passCount;
    draw(away), draw(away);
    EXPECT_GT(draw(away).splatsDrawn, 100u) << "the last frame with the avatar in view";
    draw(away);
    EXPECT_EQ(draw(away).splatsDrawn, 0u);
    for (uint32_t n = 0; n < 2 * DPL_VULKAN_SLOTS; ++n)  // nobody asks meanwhile, and each slot is prepared twice
        ASSERT_EQ(frame(count++ % DPL_VULKAN_SLOTS, image, passes, {&avatar_, 1}, {&near, 1}), DPL_OK) << dplGetLastError();
    const DplFrameStats later = draw(near);
    EXPECT_GT(later.splatsDrawn, 100u);
    EXPECT_EQ(later.frameMs > 0, stats.frameMs > 0) << "its times are still there";
    EXPECT_EQ(later.passCount, stats.passCount);
}

TEST_F(Interop, aWarmFrameAllocatesNothing) {
    OPEN_OR_SKIP({.multiview = false, .validation = false});
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_SRGB;
    const AppImage& image = target(kFormat);
    const Passes passes = passesFor(image, false);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    for (uint32_t slot = 0; slot < DPL_VULKAN_SLOTS; ++slot) ASSERT_EQ(frame(slot, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK);
    ASSERT_EQ(dplSetFrameBudget(context_, 1e-3), DPL_OK);
    std::vector<double> ms;
    uint64_t allocations = 0;
    for (uint32_t n = 0; n < 60; ++n) {
        const uint32_t slot = n % DPL_VULKAN_SLOTS;
        ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.05 * n, DPL_TRUE), DPL_OK);
        const VkCommandBuffer commands = app_->begin(slot);
        const double start = threadMs();
        AllocationCount count(CountedThreads::Own);
        const DplResult prepared = dplVulkanPrepare(context_, commands, slot, &avatar_, 1, &camera, 1, nullptr);
        allocations += count.stop();
        ms.push_back(threadMs() - start);
        ASSERT_EQ(prepared, DPL_OK) << dplGetLastError();
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        beginPass(commands, image, passes, 0);
        AllocationCount composing(CountedThreads::Own);
        ASSERT_EQ(dplVulkanCompose(context_, passes.composer, commands, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
        allocations += composing.stop();
        endPass(commands, passes);
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_->submit(slot);
    }
    std::nth_element(ms.begin(), ms.begin() + 30, ms.end());
    std::printf("prepare: %.3f ms of the calling thread a frame (median of 60)\n", ms[30]);
    EXPECT_EQ(allocations, 0u);
}

TEST_F(Interop, mistakesGetASentence) {
    OPEN_OR_SKIP({.multiview = false});
    const auto says = [](const char* text) { return std::string(dplGetLastError()).find(text) != std::string::npos; };
    DplContext none = nullptr;
    DplVulkanDevice device = lent();
    device.device = VK_NULL_HANDLE;
    EXPECT_EQ(dplCreateVulkanContext(&device, nullptr, &none), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("the device of the app's device is null")) << dplGetLastError();
    device = lent();
    device.queueFamily = 77;
    EXPECT_EQ(dplCreateVulkanContext(&device, nullptr, &none), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("queue family 77")) << dplGetLastError();
    device = lent();
    device.lockQueue = [](void*) {};
    EXPECT_EQ(dplCreateVulkanContext(&device, nullptr, &none), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("unlockQueue")) << dplGetLastError();
    device = lent();
    device.getInstanceProcAddr = [](VkInstance, const char*) -> PFN_vkVoidFunction { return nullptr; };
    EXPECT_EQ(dplCreateVulkanContext(&device, nullptr, &none), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(says("vk")) << "names the missing function: " << dplGetLastError();
    EXPECT_EQ(none, nullptr);

    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    const Passes passes = passesFor(image, false);
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.renderPass = passes.pass, pass.colourFormat = VK_FORMAT_R5G6B5_UNORM_PACK16;
    uint32_t composer = 0;
    EXPECT_EQ(dplCreateVulkanComposer(context_, &pass, &composer), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(says("VkFormat 4")) << dplGetLastError();
    pass.colourFormat = VK_FORMAT_R8G8B8A8_UNORM, pass.samples = 8;
    EXPECT_EQ(dplCreateVulkanComposer(context_, &pass, &composer), DPL_ERROR_UNSUPPORTED);
    pass.samples = 1, pass.viewMask = 3;
    EXPECT_EQ(dplCreateVulkanComposer(context_, &pass, &composer), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(says("multiview")) << dplGetLastError();
    EXPECT_EQ(dplDestroyVulkanComposer(context_, 4711), DPL_ERROR_NOT_FOUND);

    const DplCamera camera = frontCamera(kWidth, kHeight);
    const VkCommandBuffer commands = app_->begin(0);
    EXPECT_EQ(dplVulkanPrepare(context_, nullptr, 0, &avatar_, 1, &camera, 1, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplVulkanPrepare(context_, commands, DPL_VULKAN_SLOTS, &avatar_, 1, &camera, 1, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("slot 3")) << dplGetLastError();
    EXPECT_EQ(dplVulkanPrepare(context_, commands, 0, &avatar_, 0, &camera, 1, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplVulkanCompose(context_, passes.composer, commands, 0, 0, 0, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("not prepared")) << dplGetLastError();
    EXPECT_EQ(dplVulkanCompose(context_, 4711, commands, 0, 0, 0, 0), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(dplVulkanPrepare(context_, commands, 0, &avatar_, 1, &camera, 1, nullptr), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplVulkanCompose(context_, passes.composer, commands, 0, 1, 0, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("1 views") || says("with 1")) << dplGetLastError();
    app_->submit(0);

    DplVulkanSceneDepth depth{sizeof depth, 0, VK_NULL_HANDLE, VK_IMAGE_LAYOUT_GENERAL, 1, 0, 0, 0, kNear};
    EXPECT_EQ(dplVulkanPrepare(context_, app_->begin(1), 1, &avatar_, 1, &camera, 1, &depth), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("depth 0 has no image")) << dplGetLastError();
    app_->submit(1);

    const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE, 1};
    DplContext cpu = nullptr;
    ASSERT_EQ(dplCreateContext(&software, &cpu), DPL_OK);
    EXPECT_EQ(dplCreateVulkanComposer(cpu, &pass, &composer), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("dplCreateVulkanContext")) << dplGetLastError();
    EXPECT_EQ(dplDestroyContext(cpu), DPL_OK);
    DplVulkanRequirement requirement{sizeof requirement};
    uint32_t count = 0, required = 0;
    while (dplGetVulkanRequirement(count, &requirement) == DPL_OK) ++count, required += requirement.required == DPL_TRUE;
    EXPECT_EQ(count, 5u);
    EXPECT_EQ(required, 2u);
}

}  // namespace
}  // namespace dpl::test
