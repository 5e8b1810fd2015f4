// SPDX-License-Identifier: Apache-2.0
#include "tests/limits/phone.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace dpl::limits {
namespace {

/** Calls visit(structure) for each structure of a pNext list. */
template <class Visit>
void eachIn(void* list, Visit visit) {
    for (auto* at = static_cast<VkBaseOutStructure*>(list); at; at = at->pNext) visit(*at);
}

template <class T>
T& as(VkBaseOutStructure& structure) {
    return reinterpret_cast<T&>(structure);
}

}  // namespace

Phone phoneFromEnvironment() {
    Phone phone;
    if (const char* size = std::getenv("DOPPEL_PHONE_SUBGROUP")) phone.subgroupSize = uint32_t(std::strtoul(size, nullptr, 10));
    if (const char* shading = std::getenv("DOPPEL_PHONE_SAMPLE_SHADING")) phone.sampleShading = std::strcmp(shading, "0") != 0;
    return phone;
}

// Most values are the least that Vulkan allows. A comment gives the phones of 2020 that have no more, or the reason for another value.
void lowerLimits(VkPhysicalDeviceLimits& l) {
    const auto atMost = [](auto& value, auto limit) { value = std::min<std::remove_reference_t<decltype(value)>>(value, limit); };
    atMost(l.maxPerStageDescriptorStorageBuffers, 4u);
    atMost(l.maxPerStageDescriptorStorageImages, 4u);
    atMost(l.maxPerStageDescriptorUniformBuffers, 12u);
    atMost(l.maxPerStageDescriptorSampledImages, 16u);
    atMost(l.maxDescriptorSetStorageBuffers, 24u);
    atMost(l.maxDescriptorSetStorageImages, 24u);
    atMost(l.maxBoundDescriptorSets, 4u);
    atMost(l.maxPushConstantsSize, 128u);
    atMost(l.maxStorageBufferRange, 128u << 20);  // Adreno
    atMost(l.maxUniformBufferRange, 16384u);
    atMost(l.maxTexelBufferElements, 65536u);  // Mali
    for (uint32_t axis = 0; axis < 3; ++axis) atMost(l.maxComputeWorkGroupCount[axis], 65535u);
    atMost(l.maxComputeWorkGroupInvocations, 256u);  // Mali-G7x has 384, Vulkan demands 128; Doppel's scans have 256
    for (uint32_t axis = 0; axis < 3; ++axis) atMost(l.maxComputeWorkGroupSize[axis], axis < 2 ? 256u : 64u);
    atMost(l.maxComputeSharedMemorySize, 16384u);
    atMost(l.maxImageDimension2D, 8192u);
    atMost(l.maxFramebufferWidth, 8192u);
    atMost(l.maxFramebufferHeight, 8192u);
    atMost(l.maxDrawIndirectCount, 1u);
    l.timestampComputeAndGraphics = VK_FALSE;
}

void lowerProperties(VkPhysicalDeviceProperties& p) {
    lowerLimits(p.limits);
    p.apiVersion = std::min(p.apiVersion, kPhoneVersion);
    const std::string name = "phone of 2020 on " + std::string(p.deviceName);
    std::snprintf(p.deviceName, sizeof p.deviceName, "%s", name.c_str());
}

// A kernel that uses subgroups would see the driver's real size, so a size that is played comes without subgroup operations.
void lowerPropertyList(const Phone& phone, void* list) {
    eachIn(list, [&](VkBaseOutStructure& s) {
        if (s.sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES) {
            auto& p = as<VkPhysicalDeviceSubgroupProperties>(s);
            if (phone.subgroupSize == 0 || phone.subgroupSize == p.subgroupSize) return;
            p.subgroupSize = phone.subgroupSize;
            p.supportedStages = 0, p.supportedOperations = 0, p.quadOperationsInAllStages = VK_FALSE;
        } else if (s.sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES) {
            auto& p = as<VkPhysicalDeviceVulkan11Properties>(s);
            if (phone.subgroupSize == 0 || phone.subgroupSize == p.subgroupSize) return;
            p.subgroupSize = phone.subgroupSize;
            p.subgroupSupportedStages = 0, p.subgroupSupportedOperations = 0, p.subgroupQuadOperationsInAllStages = VK_FALSE;
        }
    });
}

void lowerFeatures(const Phone& phone, VkPhysicalDeviceFeatures& features) {
    VkPhysicalDeviceFeatures kept{};
    for (const auto feature :
         {&VkPhysicalDeviceFeatures::robustBufferAccess, &VkPhysicalDeviceFeatures::fullDrawIndexUint32,
          &VkPhysicalDeviceFeatures::imageCubeArray, &VkPhysicalDeviceFeatures::independentBlend,
          &VkPhysicalDeviceFeatures::sampleRateShading, &VkPhysicalDeviceFeatures::samplerAnisotropy,
          &VkPhysicalDeviceFeatures::textureCompressionETC2, &VkPhysicalDeviceFeatures::occlusionQueryPrecise,
          &VkPhysicalDeviceFeatures::fragmentStoresAndAtomics, &VkPhysicalDeviceFeatures::shaderUniformBufferArrayDynamicIndexing,
          &VkPhysicalDeviceFeatures::shaderSampledImageArrayDynamicIndexing,
          &VkPhysicalDeviceFeatures::shaderStorageBufferArrayDynamicIndexing,
          &VkPhysicalDeviceFeatures::shaderStorageImageArrayDynamicIndexing})
        kept.*feature = features.*feature;
    if (!phone.sampleShading) kept.sampleRateShading = VK_FALSE;
    features = kept;
}

// A phone with Vulkan 1.1 does not know the structures of later versions.
void lowerFeatureList(void* list) {
    eachIn(list, [](VkBaseOutStructure& s) {
        switch (s.sType) {
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES:
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES:
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES:
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES:
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES:
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES:
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES: {
                const FeatureFlags flags = flagsOf(reinterpret_cast<const VkBaseInStructure&>(s));
                std::fill_n(const_cast<VkBool32*>(flags.first), flags.count, VK_FALSE);
                break;
            }
            default:
                break;
        }
    });
}

void lowerQueueFamily(VkQueueFamilyProperties& family) {
    family.timestampValidBits = 0;
}

void lowerFormat(VkFormat format, VkFormatProperties& properties) {  // Mali blends no 32-bit floats
    if (format == VK_FORMAT_R32_SFLOAT || format == VK_FORMAT_R32G32_SFLOAT || format == VK_FORMAT_R32G32B32A32_SFLOAT)
        properties.optimalTilingFeatures &= ~VkFormatFeatureFlags(VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT);
}

FeatureFlags flagsOf(const VkBaseInStructure& s) {
#define DPL_FEATURES(type, structure, firstFlag, lastFlag)                                                    \
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##type##_FEATURES: {                                               \
        const auto& features = reinterpret_cast<const VkPhysicalDevice##structure##Features&>(s);             \
        return {&features.firstFlag, size_t(&features.lastFlag - &features.firstFlag) + 1, sizeof(features)}; \
    }
    switch (s.sType) {
        DPL_FEATURES(MULTIVIEW, Multiview, multiview, multiviewTessellationShader)
        DPL_FEATURES(SHADER_FLOAT16_INT8, ShaderFloat16Int8, shaderFloat16, shaderInt8)
        DPL_FEATURES(16BIT_STORAGE, 16BitStorage, storageBuffer16BitAccess, storageInputOutput16)
        DPL_FEATURES(8BIT_STORAGE, 8BitStorage, storageBuffer8BitAccess, storagePushConstant8)
        DPL_FEATURES(VARIABLE_POINTERS, VariablePointers, variablePointersStorageBuffer, variablePointers)
        DPL_FEATURES(SAMPLER_YCBCR_CONVERSION, SamplerYcbcrConversion, samplerYcbcrConversion, samplerYcbcrConversion)
        DPL_FEATURES(PROTECTED_MEMORY, ProtectedMemory, protectedMemory, protectedMemory)
        DPL_FEATURES(SHADER_DRAW_PARAMETERS, ShaderDrawParameters, shaderDrawParameters, shaderDrawParameters)
        DPL_FEATURES(TIMELINE_SEMAPHORE, TimelineSemaphore, timelineSemaphore, timelineSemaphore)
        DPL_FEATURES(SUBGROUP_SIZE_CONTROL, SubgroupSizeControl, subgroupSizeControl, computeFullSubgroups)
        DPL_FEATURES(DYNAMIC_RENDERING, DynamicRendering, dynamicRendering, dynamicRendering)
        DPL_FEATURES(VULKAN_1_1, Vulkan11, storageBuffer16BitAccess, shaderDrawParameters)
        DPL_FEATURES(VULKAN_1_2, Vulkan12, samplerMirrorClampToEdge, subgroupBroadcastDynamicId)
        DPL_FEATURES(VULKAN_1_3, Vulkan13, robustImageAccess, maintenance4)
        default:
            return {};
    }
#undef DPL_FEATURES
}

}  // namespace dpl::limits
