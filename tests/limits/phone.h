// SPDX-License-Identifier: Apache-2.0
// What a phone of 2020 reports about itself: the limits and features that the layer shows instead of the driver's own.
#pragma once

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

namespace dpl::limits {

/** Read from the environment when the instance is made. */
struct Phone {
    uint32_t subgroupSize = 0;  // DOPPEL_PHONE_SUBGROUP: 4 to 128; 0 shows the driver's own
    bool sampleShading = true;  // DOPPEL_PHONE_SAMPLE_SHADING=0: no shading of single samples, so no picture with four samples a pixel
};
Phone phoneFromEnvironment();

constexpr uint32_t kPhoneVersion = VK_MAKE_API_VERSION(0, 1, 1, 128);
constexpr const char* kHiddenExtensions[] = {"VK_KHR_dynamic_rendering", "VK_KHR_multiview", "VK_KHR_shader_float16_int8",
                                             "VK_EXT_subgroup_size_control"};

/** Each lowers what the driver wrote and never raises it. The lists of structures (pNext) are searched for those that the layer knows. */
void lowerLimits(VkPhysicalDeviceLimits& limits);
void lowerProperties(VkPhysicalDeviceProperties& properties);
void lowerPropertyList(const Phone& phone, void* list);
void lowerFeatures(const Phone& phone, VkPhysicalDeviceFeatures& features);
void lowerFeatureList(void* list);
void lowerQueueFamily(VkQueueFamilyProperties& family);
void lowerFormat(VkFormat format, VkFormatProperties& properties);

/** The booleans of a structure of features: `count` of them at `first`. count 0: the layer does not know the structure. */
struct FeatureFlags {
    const VkBool32* first = nullptr;
    size_t count = 0;
    size_t bytes = 0;  // of the whole structure
};
FeatureFlags flagsOf(const VkBaseInStructure& structure);

}  // namespace dpl::limits
