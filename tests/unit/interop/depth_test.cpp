// SPDX-License-Identifier: Apache-2.0
// The avatar's depth in a program's depth attachment: what dplRender reads back, in every convention, format and number of samples; and
// the program's own depth where the avatar is behind it, or hardly covers a pixel.
#include "apps/bench/count_allocations.h"
#include "tests/unit/interop/interop_fixture.h"
#include "tests/unit/interop/sample_brush.h"

namespace dpl::test {
namespace {

struct StoredCase {
    const char* name;
    VkFormat format;
    reference::StoredDepth how;
    double clear;  // stored where there is no scene
    double step;   // one code: how far two values may be apart
};
constexpr double kSpan = double(kFar) - double(kNear);
constexpr reference::StoredDepth kUsual{kFar / kSpan, -double(kFar) * double(kNear) / kSpan},
    kReversed{-double(kNear) / kSpan, double(kFar) * double(kNear) / kSpan};
constexpr double kOneStep = 1.05;
constexpr double kTwoSteps = 2.05;              // of D24: shaders write floats, whose steps below 1 are as coarse as its codes
constexpr double kFloatStep = 1.0 / (1 << 24);  // a code of D32 below 1
constexpr StoredCase kStored[] = {{"usual, D32", VK_FORMAT_D32_SFLOAT, kUsual, 1, kFloatStep},
                                  {"usual, D16", VK_FORMAT_D16_UNORM, kUsual, 1, 1.0 / 65535},
                                  {"usual, D24", VK_FORMAT_D24_UNORM_S8_UINT, kUsual, 1, 1.0 / 16777215},
                                  {"usual infinite, D32", VK_FORMAT_D32_SFLOAT, {1, -double(kNear)}, 1, kFloatStep},
                                  {"reversed, D32", VK_FORMAT_D32_SFLOAT, kReversed, 0, kFloatStep},
                                  {"reversed, D16", VK_FORMAT_D16_UNORM, kReversed, 0, 1.0 / 65535},
                                  {"reversed infinite, D32", VK_FORMAT_D32_SFLOAT, {0, double(kNear)}, 0, kFloatStep}};

/** A scene of nothing, a near wall and a far wall in small fields, and one of each among the samples of a pixel. */
std::vector<SampleValue> fields(const StoredCase& stored, uint32_t samples) {
    std::vector<SampleValue> values(size_t(kWidth) * kHeight * samples);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x)
            for (uint32_t s = 0; s < samples; ++s) {
                SampleValue& value = values[(size_t(y) * kWidth + x) * samples + s];
                value.rgba = {0.8f * float(x) / kWidth, 0.9f * float(y) / kHeight, 0.3f + 0.15f * float(s), 1};
                const uint32_t field = (x / 6 + y / 5 + s) % 3;
                value.depth = float(field == 0 ? stored.clear : stored.how.of(field == 1 ? 1.5 : 5));  // the avatar stands 3 m away
            }
    return values;
}

struct Written {
    size_t nearer = 0, behind = 0, uncovered = 0;  // samples
    double worst = 0;                              // difference of those that are nearer, in steps
};
/** Compares each sample with the referee's. before, after: of the same pixels. */
Written compare(const StoredCase& stored, uint32_t samples, std::span<const uint8_t> layer, std::span<const float> depthM,
                const std::vector<SampleValue>& before, const std::vector<SampleValue>& after) {
    Written result;
    std::vector<double> want(before.size());
    for (size_t i = 0; i < want.size(); ++i) want[i] = double(before[i].depth);
    reference::composeDepth(layer, depthM, stored.how, samples, want);
    for (size_t i = 0; i < want.size(); ++i) {
        const double old = double(before[i].depth), got = double(after[i].depth);
        if (std::abs(want[i] - old) > 2 * stored.step) {
            ++result.nearer;
            const double code = stored.format == VK_FORMAT_D32_SFLOAT ? want[i] : std::round(want[i] / stored.step) * stored.step;
            result.worst = std::max(result.worst, std::abs(got - code) / stored.step);
        } else {
            const bool written = layer[i / samples * 4 + 3] >= 128 && depthM[i / samples] > 0;
            ++(written ? result.behind : result.uncovered);
            if (want[i] == old) {
                EXPECT_EQ(after[i].depth, before[i].depth) << "sample " << i << " keeps its bits";
            }
        }
    }
    return result;
}

// The formats of targets take turns: colour and depth do not depend on each other.
constexpr VkFormat kColours[] = {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT,
                                 VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_B8G8R8A8_UNORM};

/** What the target stores of a sample. */
reference::StoredPixel storedOf(const SampleValue& value, VkFormat format) {
    reference::StoredPixel stored;
    for (size_t c = 0; c < 4; ++c) {
        stored[c] = double(value.rgba[c]);
        if (c < 3 && reference::isSrgb(refereeFormat(format))) stored[c] = reference::encodeSrgb(stored[c]);
    }
    return stored;
}

struct WayCase {
    const char* name;
    uint32_t depth;  // DplDrawFlag
    DplFill fill;
    bool dynamic;
    bool all;  // conventions, formats and numbers of samples, which do not depend on the others; else two of them
};
class InteropDepthWriting : public Interop, public testing::WithParamInterface<WayCase> {};
INSTANTIATE_TEST_SUITE_P(Ways, InteropDepthWriting,
                         testing::Values(WayCase{"SplatsQuadsRenderPass", DPL_DRAW_DEPTH, DPL_FILL_QUADS, false, true},
                                         WayCase{"SplatsTilesDynamicRendering", DPL_DRAW_DEPTH, DPL_FILL_TILES, true, false},
                                         WayCase{"MeshQuadsDynamicRendering", DPL_DRAW_MESH_DEPTH, DPL_FILL_QUADS, true, false},
                                         WayCase{"MeshTilesRenderPass", DPL_DRAW_MESH_DEPTH, DPL_FILL_TILES, false, false}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(InteropDepthWriting, writesWhatDplRenderReadsBack) {
    const auto [name, which, fill, dynamic, all] = GetParam();
    OPEN_OR_SKIP({.multiview = false, .dynamicRendering = dynamic}, fill);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    std::vector<float> depthM, meshDepthM;
    const std::vector<uint8_t> layer = layerOf(camera, &depthM, &meshDepthM);
    SampleBrush brush(*app_);
    uint32_t slot = 0;
    for (const StoredCase& stored : kStored) {
        const bool first = &stored == &kStored[0], last = &stored == &kStored[std::size(kStored) - 1];
        if (!all && !first && !last) continue;
        if (!app_->isDepthTarget(stored.format)) {
            std::printf("%s: not on this device\n", stored.name);
            continue;
        }
        for (const uint32_t samples : {1u, 4u}) {
            if (!all && samples != (first ? 4u : 1u)) continue;
            SCOPED_TRACE(stored.name + std::string(samples == 1 ? ", 1 sample" : ", 4 samples"));
            const VkFormat format = kColours[slot % std::size(kColours)];
            const AppImage& image = target(format, 1, samples);
            images_.push_back(app_->makeDepthTarget(stored.format, kWidth, kHeight, 1, samples));
            const AppImage& depth = images_.back();
            Passes passes = passesFor(image, dynamic, 0, &depth, which);
            passes.stored = stored.how;
            brush.paint(image, depth, 0, fields(stored, samples));
            const auto before = brush.fetch(image, depth, 0);
            ASSERT_EQ(frame(slot++ % DPL_VULKAN_SLOTS, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
            const auto after = brush.fetch(image, depth, 0);
            const Written written = compare(stored, samples, layer, which == DPL_DRAW_DEPTH ? depthM : meshDepthM, before, after);
            std::printf("%s, %u samples: %zu samples nearer, %.2f steps at most; %zu behind, %zu not covered\n", stored.name, samples,
                        written.nearer, written.worst, written.behind, written.uncovered);
            EXPECT_LE(written.worst, stored.format == VK_FORMAT_D24_UNORM_S8_UINT ? kTwoSteps : kOneStep);
            EXPECT_GT(written.nearer, 300u * samples);
            EXPECT_GT(written.behind, 150u * samples);
            EXPECT_GT(written.uncovered, 3000u * samples);
            size_t wrong = 0;
            for (size_t i = 0; i < after.size(); ++i) {
                const auto got = storedOf(after[i], format);
                wrong += !mayGive(format, fill, &layer[i / samples * 4], storedOf(before[i], format), got);
            }
            EXPECT_EQ(wrong, 0u) << "colours of each sample are the referee's";
        }
    }
}

class InteropArrayDepth : public Interop, public testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(Ways, InteropArrayDepth, testing::Bool(),
                         [](const auto& info) { return std::string(info.param ? "Multiview" : "AnImageAnEye"); });

TEST_P(InteropArrayDepth, eachEyeGetsItsDepth) {
    const bool multiview = GetParam();
    OPEN_OR_SKIP({.multiview = multiview}, DPL_FILL_TILES);
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    if (multiview && !canMask()) GTEST_SKIP() << dplGetLastError();
    const AppImage& image = target(kFormat, 2);
    const StoredCase& stored = kStored[0];
    images_.push_back(app_->makeDepthTarget(stored.format, kWidth, kHeight, 2));
    const AppImage& depth = images_.back();
    SampleBrush brush(*app_);
    for (const uint32_t which : {uint32_t(DPL_DRAW_DEPTH), uint32_t(DPL_DRAW_MESH_DEPTH)}) {
        Passes passes = passesFor(image, false, multiview ? 3 : 0, &depth, which);
        passes.stored = stored.how;
        for (const bool canted : {false, true}) {
            DplCamera eyes[2] = {frontCamera(kWidth, kHeight, 0.03f), frontCamera(kWidth, kHeight, -0.03f)};
            if (canted) cant(eyes[1]);
            for (uint32_t eye = 0; eye < 2; ++eye) brush.paint(image, depth, eye, fields(stored, 1));
            const auto before = brush.fetch(image, depth, 0);
            ASSERT_EQ(frame(canted, image, passes, {&avatar_, 1}, eyes), DPL_OK) << dplGetLastError();
            std::vector<uint8_t> layers[2];
            std::vector<float> depths[2];
            DplImage images[2]{};
            for (uint32_t eye = 0; eye < 2; ++eye) {
                layers[eye].resize(size_t(kWidth) * kHeight * 4), depths[eye].resize(size_t(kWidth) * kHeight);
                images[eye] = {sizeof(DplImage), 0, layers[eye].data(), layers[eye].size()};
                (which == DPL_DRAW_DEPTH ? images[eye].depthM : images[eye].meshDepthM) = depths[eye].data();
                (which == DPL_DRAW_DEPTH ? images[eye].depthCount : images[eye].meshDepthCount) = depths[eye].size();
            }
            ASSERT_EQ(dplRender(context_, avatar_, eyes, 2, images), DPL_OK) << dplGetLastError();
            for (uint32_t eye = 0; eye < 2; ++eye) {
                const Written written = compare(stored, 1, layers[eye], depths[eye], before, brush.fetch(image, depth, eye));
                std::printf("%s, eye %u: %zu samples nearer, %.2f steps at most\n", canted ? "canted" : "parallel", eye, written.nearer,
                            written.worst);
                EXPECT_GT(written.nearer, 300u);
                EXPECT_LE(written.worst, kOneStep);
            }
        }
    }
}

TEST_F(Interop, aDepthImageMayHideTheAvatarAndThenHoldItsDepth) {
    OPEN_OR_SKIP({.multiview = false});
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    const StoredCase& stored = kStored[6];
    const AppImage& image = target(kFormat);
    images_.push_back(app_->makeDepthTarget(stored.format, kWidth, kHeight));
    const AppImage& depth = images_.back();
    Passes passes = passesFor(image, false, 0, &depth, DPL_DRAW_DEPTH);
    SampleBrush brush(*app_);
    const auto before = fields(stored, 1);
    brush.paint(image, depth, 0, before);
    DplCamera camera = frontCamera(kWidth, kHeight);
    const DplVulkanSceneDepth scene{sizeof scene,
                                    0,
                                    depth.view,
                                    VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL,
                                    1,
                                    0,
                                    0,
                                    float(stored.how.scale),
                                    float(stored.how.offset)};
    const VkCommandBuffer commands = app_->begin(0);
    app_->barrier(commands, depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL);
    ASSERT_EQ(dplVulkanPrepare(context_, commands, 0, &avatar_, 1, &camera, 1, &scene), DPL_OK) << dplGetLastError();
    app_->barrier(commands, depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    app_->barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    beginPass(commands, image, passes, 0);
    ASSERT_EQ(dplVulkanComposeDepth(context_, passes.composer, commands, 0, 0, 0, 0, scene.scale, scene.offset), DPL_OK);
    ASSERT_EQ(dplVulkanCompose(context_, passes.composer, commands, 0, 0, 0, 0), DPL_OK) << dplGetLastError();
    endPass(commands, passes);
    app_->barrier(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    app_->submit(0);
    std::vector<float> sceneM(before.size()), depthM;
    for (size_t i = 0; i < sceneM.size(); ++i) sceneM[i] = before[i].depth > 0 ? scene.offset / before[i].depth : 0;
    camera.sceneDepthM = sceneM.data(), camera.sceneDepthCount = sceneM.size();
    const auto layer = layerOf(camera, &depthM);
    const Written written = compare(stored, 1, layer, depthM, before, brush.fetch(image, depth, 0));
    EXPECT_GT(written.nearer, 300u);
    EXPECT_LE(written.worst, kOneStep);
}

TEST_F(Interop, depthIsDrawnWhileAComposerWritesIt) {
    OPEN_OR_SKIP({.multiview = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    images_.push_back(app_->makeDepthTarget(VK_FORMAT_D32_SFLOAT, kWidth, kHeight));
    const AppImage& depth = images_.back();
    const Passes plain = passesFor(image, false, 0, &depth);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const auto says = [](const char* text) { return std::string(dplGetLastError()).find(text) != std::string::npos; };
    ASSERT_EQ(frame(0, image, plain, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();

    Passes passes = passesFor(image, false, 0, &depth, DPL_DRAW_DEPTH);
    const VkCommandBuffer commands = app_->begin(1);
    const auto writes = [&](uint32_t composer, uint32_t slot, float scale, float offset) {
        return dplVulkanComposeDepth(context_, composer, commands, slot, 0, 0, 0, scale, offset);
    };
    EXPECT_EQ(writes(plain.composer, 0, 0, kNear), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("writes no depth")) << dplGetLastError();
    EXPECT_EQ(writes(passes.composer, 0, 0, kNear), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("before composer")) << dplGetLastError();
    EXPECT_EQ(writes(passes.composer, 2, 0, kNear), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("not prepared")) << dplGetLastError();
    EXPECT_EQ(writes(4711, 0, 0, kNear), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(writes(passes.composer, 0, 1, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("offset 0")) << dplGetLastError();
    EXPECT_EQ(writes(passes.composer, 0, NAN, kNear), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplVulkanComposeDepth(context_, passes.composer, nullptr, 0, 0, 0, 0, 0, kNear), DPL_ERROR_INVALID_ARGUMENT);
    app_->submit(1);

    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.colourFormat = VK_FORMAT_R8G8B8A8_UNORM, pass.writesDepth = 3;
    uint32_t composer = 0;
    EXPECT_EQ(dplCreateVulkanComposer(context_, &pass, &composer), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("writesDepth")) << dplGetLastError();
    pass.writesDepth = DPL_DRAW_DEPTH, pass.depthFormat = VK_FORMAT_S8_UINT;
    EXPECT_EQ(dplCreateVulkanComposer(context_, &pass, &composer), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(says("depthFormat")) << dplGetLastError();

    passes.stored = kStored[6].how;
    ASSERT_EQ(frame(0, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
    DplVulkanSceneDepth written{sizeof written, 0, depth.view, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, 1, 0, 0, 0, kNear};
    EXPECT_EQ(dplVulkanPrepare(context_, app_->begin(1), 1, &avatar_, 1, &camera, 1, &written), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("layout")) << dplGetLastError();
    app_->submit(1);
    ASSERT_EQ(dplDestroyVulkanComposer(context_, passes.composer), DPL_OK);
    ASSERT_EQ(frame(1, image, plain, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
}

TEST_F(Interop, aWarmFrameThatWritesDepthAllocatesNothing) {
    OPEN_OR_SKIP({.multiview = false, .validation = false});
    const AppImage& image = target(VK_FORMAT_R8G8B8A8_UNORM);
    images_.push_back(app_->makeDepthTarget(VK_FORMAT_D32_SFLOAT, kWidth, kHeight));
    Passes passes = passesFor(image, false, 0, &images_.back(), DPL_DRAW_MESH_DEPTH);
    passesFor(image, false, 0, &images_.back(), DPL_DRAW_DEPTH);
    passes.stored = kStored[0].how;
    const DplCamera camera = frontCamera(kWidth, kHeight);
    for (uint32_t n = 0; n < 9; ++n) {
        AllocationCount count(CountedThreads::Own);
        ASSERT_EQ(frame(n % DPL_VULKAN_SLOTS, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
        const uint64_t allocations = count.stop();
        if (n >= DPL_VULKAN_SLOTS) {
            EXPECT_EQ(allocations, 0u);
        }
    }
}

}  // namespace
}  // namespace dpl::test
