// SPDX-License-Identifier: Apache-2.0
// Fills and reads every sample of a colour and a depth image, which no copy command can do.
#pragma once

#include <array>
#include <map>

#include "platform/common/vulkan_help.h"
#include "tests/unit/interop/app_device.h"

namespace dpl::test {

/** One sample. Colour as a shader sees it: linear light of an sRGB image. */
struct SampleValue {
    std::array<float, 4> rgba{};
    float depth = 0;
};

/** Samples of a pixel follow each other. Both calls wait. Errors abort the test, as those of AppDevice. */
class SampleBrush {
public:
    explicit SampleBrush(AppDevice& app) : app_(app) {}
    ~SampleBrush();
    SampleBrush(const SampleBrush&) = delete;
    SampleBrush& operator=(const SampleBrush&) = delete;

    /** Images of the same size and samples, in the layouts between frames (AppDevice). */
    void paint(const AppImage& colour, const AppImage& depth, uint32_t layer, std::span<const SampleValue> values);
    std::vector<SampleValue> fetch(const AppImage& colour, const AppImage& depth, uint32_t layer);

private:
    struct Kit {  // to paint images of two formats
        VkRenderPass pass = VK_NULL_HANDLE;
        VkPipeline pipeline = VK_NULL_HANDLE;
    };
    struct Layout {
        VkDescriptorSetLayout set = VK_NULL_HANDLE;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        VkDescriptorPool pool = VK_NULL_HANDLE;
        VkDescriptorSet descriptors = VK_NULL_HANDLE;
    };
    Kit& kitFor(const AppImage& colour, const AppImage& depth);
    VkPipeline reader(uint32_t samples);
    void makeLayout(Layout& layout, bool images, VkShaderStageFlags stage);
    void makeBuffer(size_t values);

    AppDevice& app_;
    std::map<std::array<uint32_t, 3>, Kit> kits_;  // by formats and samples
    VkPipeline readers_[2]{};                      // of one sample, of four
    Layout painting_, reading_;
    platform::HostBuffer buffer_;
    size_t capacity_ = 0;  // of it, values
};

}  // namespace dpl::test
