// SPDX-License-Identifier: Apache-2.0
// Flicker in the picture of a slowly turning camera: changes from frame to frame that are not smooth motion. The referee itself flickers a
// little, because splats swap order and pixels are rounded to bytes. The renderer may add little to that.
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

constexpr int kFrames = 20;
constexpr float kStepRad = 0.0015f;  // 0.09 degrees a frame: a head that turns by 6 degrees a second, at 72 Hz

/** Second differences over time of 8-bit values: zero where brightness is constant or changes linearly. */
struct Flicker {
    double mean = 0, largest = 0;
    size_t pops = 0;  // values above kPopLevels
};
constexpr double kPopLevels = 40;

Flicker flickerOf(const std::vector<std::vector<uint8_t>>& frames) {
    Flicker f;
    double sum = 0;
    size_t count = 0;
    for (size_t t = 1; t + 1 < frames.size(); ++t)
        for (size_t i = 0; i < frames[t].size(); ++i) {
            const double change = std::abs(double(frames[t - 1][i]) - 2.0 * frames[t][i] + frames[t + 1][i]);
            sum += change, f.largest = std::max(f.largest, change), f.pops += change > kPopLevels;
            count += frames[t][i] > 0;
        }
    f.mean = sum / double(std::max<size_t>(1, count));
    return f;
}

std::vector<uint8_t> bytesOf(const ReferenceImage& image) {
    std::vector<uint8_t> bytes;
    for (size_t i = 0; i < image.alpha.size(); ++i) {
        for (size_t c = 0; c < 3; ++c) bytes.push_back(uint8_t(std::lround(std::clamp(image.rgb[i * 3 + c], 0.0, 1.0) * 255)));
        bytes.push_back(uint8_t(std::lround(image.alpha[i] * 255)));
    }
    return bytes;
}

TEST_P(VulkanImage, aSlowlyTurningCameraFlickersNoMoreThanTheReference) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const auto avatar = share(makeTube({.singleFace = true, .colourSpread = 0.4f}));
    const auto id = vulkan.renderer->addAvatar(avatar);
    ASSERT_TRUE(id) << id.error().message;
    const Pose pose = tubePose(0.6f);
    std::vector<std::vector<uint8_t>> drawn, wanted;
    for (int t = 0; t < kFrames; ++t) {
        const Cameraf camera = tubeCamera(120, 128, 0.4f + kStepRad * float(t), 1.3f);
        drawn.push_back(drawOne(*vulkan.renderer, *id, pose, camera).rgba);
        wanted.push_back(bytesOf(renderReference(*avatar, pose, referenceCamera(camera))));
    }
    const Flicker ours = flickerOf(drawn), reference = flickerOf(wanted);
    std::printf("[ FLICKER  ] a covered value: %.4f levels (reference %.4f), largest %.0f (%.0f), above %.0f levels: %zu (%zu)\n",
                ours.mean, reference.mean, ours.largest, reference.largest, kPopLevels, ours.pops, reference.pops);
    EXPECT_GT(reference.mean, 0.01);  // the picture moves
    EXPECT_LE(ours.mean, reference.mean * 1.05);
    EXPECT_LE(ours.pops, reference.pops + reference.pops / 10 + 4);
}

}  // namespace
}  // namespace dpl
