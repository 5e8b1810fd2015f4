// SPDX-License-Identifier: Apache-2.0
// A Vulkan layer that plays a phone of 2020 (phone.cpp) on top of any driver. It reports less than the driver has, and it refuses whatever
// goes beyond what it reported: it prints a sentence to stderr, and the call returns VK_ERROR_VALIDATION_FAILED_EXT. Calls without a result
// make the next vkEndCommandBuffer or vkQueueSubmit fail.
//
// Not seen: group counts of indirect dispatches and instance counts of indirect draws (they are in GPU memory), and descriptors that are
// written through templates or pushed. The validation layer, above this one, compares the rest with the lowered limits too.
#include <algorithm>
#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "tests/limits/layer_link.h"
#include "tests/limits/phone.h"
#include "tests/limits/spirv_needs.h"

namespace dpl::limits {
namespace {

constexpr VkResult kRefused = VK_ERROR_VALIDATION_FAILED_EXT;

#define DPL_NEXT_INSTANCE(DO)                \
    DO(vkDestroyInstance)                    \
    DO(vkEnumerateDeviceExtensionProperties) \
    DO(vkGetPhysicalDeviceFeatures)          \
    DO(vkGetPhysicalDeviceFeatures2)         \
    DO(vkGetPhysicalDeviceFormatProperties)  \
    DO(vkGetPhysicalDeviceFormatProperties2) \
    DO(vkGetPhysicalDeviceProperties)        \
    DO(vkGetPhysicalDeviceProperties2)       \
    DO(vkGetPhysicalDeviceQueueFamilyProperties) DO(vkGetPhysicalDeviceQueueFamilyProperties2)

#define DPL_NEXT_DEVICE(DO)          \
    DO(vkCmdDispatch)                \
    DO(vkCmdDispatchBase)            \
    DO(vkCmdDrawIndirect)            \
    DO(vkCmdDrawIndexedIndirect)     \
    DO(vkCmdWriteTimestamp)          \
    DO(vkCreateBuffer)               \
    DO(vkCreateDescriptorSetLayout)  \
    DO(vkCreateGraphicsPipelines)    \
    DO(vkCreatePipelineLayout)       \
    DO(vkCreateRenderPass)           \
    DO(vkCreateShaderModule)         \
    DO(vkDestroyBuffer)              \
    DO(vkDestroyDescriptorSetLayout) \
    DO(vkDestroyDevice)              \
    DO(vkEndCommandBuffer)           \
    DO(vkQueueSubmit)                \
    DO(vkUpdateDescriptorSets)

#define DPL_MEMBER(name) PFN_##name name = nullptr;

struct Instance {
    VkInstance handle = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr nextProc = nullptr;
    Phone phone;
    DPL_NEXT_INSTANCE(DPL_MEMBER)
};

struct Device {
    VkDevice handle = VK_NULL_HANDLE;
    PFN_vkGetDeviceProcAddr nextProc = nullptr;
    DPL_NEXT_DEVICE(DPL_MEMBER)
    VkPhysicalDeviceLimits limits{};                 // as reported
    VkPhysicalDeviceSubgroupProperties subgroups{};  // as reported
    VkPhysicalDeviceFeatures features{};             // enabled; so are those below
    bool multiview = false, storage16 = false, storage8 = false, drawParameters = false;

    std::atomic<bool> broken{false};  // a call without a result went too far
    std::mutex mutex;                 // guards the maps
    std::unordered_map<VkDescriptorSetLayout, std::vector<VkDescriptorSetLayoutBinding>> setLayouts;
    std::unordered_map<VkBuffer, VkDeviceSize> bufferBytes;
};

std::mutex tablesMutex;
std::unordered_map<void*, std::shared_ptr<Instance>> instances;
std::unordered_map<void*, std::shared_ptr<Device>> devices;

template <class Handle>
std::shared_ptr<Instance> instanceOf(Handle handle) {
    std::lock_guard lock(tablesMutex);
    return instances.at(keyOf(handle));
}
template <class Handle>
std::shared_ptr<Device> deviceOf(Handle handle) {
    std::lock_guard lock(tablesMutex);
    return devices.at(keyOf(handle));
}

__attribute__((format(printf, 1, 2))) VkResult refuse(const char* text, ...) {
    std::va_list arguments;
    va_start(arguments, text);
    std::fputs("limits layer: ", stderr);
    std::vfprintf(stderr, text, arguments);
    std::fputc('\n', stderr);
    va_end(arguments);
    return kRefused;
}

// ── what the phone reports ──────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR void VKAPI_CALL getProperties(VkPhysicalDevice physical, VkPhysicalDeviceProperties* properties) {
    instanceOf(physical)->vkGetPhysicalDeviceProperties(physical, properties);
    lowerProperties(*properties);
}

VKAPI_ATTR void VKAPI_CALL getProperties2(VkPhysicalDevice physical, VkPhysicalDeviceProperties2* properties) {
    const auto instance = instanceOf(physical);
    instance->vkGetPhysicalDeviceProperties2(physical, properties);
    lowerProperties(properties->properties);
    lowerPropertyList(instance->phone, properties->pNext);
}

VKAPI_ATTR void VKAPI_CALL getFeatures(VkPhysicalDevice physical, VkPhysicalDeviceFeatures* features) {
    const auto instance = instanceOf(physical);
    instance->vkGetPhysicalDeviceFeatures(physical, features);
    lowerFeatures(instance->phone, *features);
}

VKAPI_ATTR void VKAPI_CALL getFeatures2(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2* features) {
    const auto instance = instanceOf(physical);
    instance->vkGetPhysicalDeviceFeatures2(physical, features);
    lowerFeatures(instance->phone, features->features);
    lowerFeatureList(features->pNext);
}

VKAPI_ATTR void VKAPI_CALL getQueueFamilies(VkPhysicalDevice physical, uint32_t* count, VkQueueFamilyProperties* families) {
    instanceOf(physical)->vkGetPhysicalDeviceQueueFamilyProperties(physical, count, families);
    for (uint32_t i = 0; families && i < *count; ++i) lowerQueueFamily(families[i]);
}

VKAPI_ATTR void VKAPI_CALL getQueueFamilies2(VkPhysicalDevice physical, uint32_t* count, VkQueueFamilyProperties2* families) {
    instanceOf(physical)->vkGetPhysicalDeviceQueueFamilyProperties2(physical, count, families);
    for (uint32_t i = 0; families && i < *count; ++i) lowerQueueFamily(families[i].queueFamilyProperties);
}

VKAPI_ATTR void VKAPI_CALL getFormat(VkPhysicalDevice physical, VkFormat format, VkFormatProperties* properties) {
    instanceOf(physical)->vkGetPhysicalDeviceFormatProperties(physical, format, properties);
    lowerFormat(format, *properties);
}

VKAPI_ATTR void VKAPI_CALL getFormat2(VkPhysicalDevice physical, VkFormat format, VkFormatProperties2* properties) {
    instanceOf(physical)->vkGetPhysicalDeviceFormatProperties2(physical, format, properties);
    lowerFormat(format, properties->formatProperties);
}

bool hidden(const char* extension) {
    return std::any_of(std::begin(kHiddenExtensions), std::end(kHiddenExtensions),
                       [&](const char* name) { return std::strcmp(name, extension) == 0; });
}

VKAPI_ATTR VkResult VKAPI_CALL getDeviceExtensions(VkPhysicalDevice physical, const char* layer, uint32_t* count,
                                                   VkExtensionProperties* properties) {
    const auto instance = instanceOf(physical);
    if (layer) return instance->vkEnumerateDeviceExtensionProperties(physical, layer, count, properties);
    uint32_t all = 0;
    if (const VkResult r = instance->vkEnumerateDeviceExtensionProperties(physical, nullptr, &all, nullptr); r != VK_SUCCESS) return r;
    std::vector<VkExtensionProperties> list(all);
    if (const VkResult r = instance->vkEnumerateDeviceExtensionProperties(physical, nullptr, &all, list.data()); r < 0) return r;
    std::erase_if(list, [](const VkExtensionProperties& e) { return hidden(e.extensionName); });
    if (!properties) {
        *count = uint32_t(list.size());
        return VK_SUCCESS;
    }
    *count = std::min(*count, uint32_t(list.size()));
    std::copy_n(list.begin(), *count, properties);
    return *count < list.size() ? VK_INCOMPLETE : VK_SUCCESS;
}

// ── instance and device ─────────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                              VkInstance* instance) {
    auto* link = linkIn<VkLayerInstanceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const auto nextProc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(nextProc(VK_NULL_HANDLE, "vkCreateInstance"));
    if (!create) return VK_ERROR_INITIALIZATION_FAILED;
    if (const VkResult result = create(info, allocator, instance); result != VK_SUCCESS) return result;
    auto made = std::make_shared<Instance>();
    made->handle = *instance;
    made->nextProc = nextProc;
    made->phone = phoneFromEnvironment();
#define DPL_LOAD(name) made->name = reinterpret_cast<PFN_##name>(nextProc(*instance, #name));
    DPL_NEXT_INSTANCE(DPL_LOAD)
#undef DPL_LOAD
    std::lock_guard lock(tablesMutex);
    instances[keyOf(*instance)] = made;
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroyInstance(VkInstance instance, const VkAllocationCallbacks* allocator) {
    if (!instance) return;
    const auto gone = instanceOf(instance);
    void* const key = keyOf(instance);
    gone->vkDestroyInstance(instance, allocator);
    std::lock_guard lock(tablesMutex);
    instances.erase(key);
}

/** Compares the booleans of `wanted` with what the phone reports, and names the first that is not reported by its place. */
VkResult checkFlags(VkPhysicalDevice physical, const VkBaseInStructure& wanted) {
    const FeatureFlags flags = flagsOf(wanted);
    if (flags.count == 0) {
        // The loader's own structures, and those that enable nothing.
        if (wanted.sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO ||
            wanted.sType == VK_STRUCTURE_TYPE_DEVICE_GROUP_DEVICE_CREATE_INFO)
            return VK_SUCCESS;
        return refuse(
            "vkCreateDevice has a structure of type %d, which this layer does not know; add it to flagsOf() in tests/limits/phone.cpp",
            int(wanted.sType));
    }
    std::vector<uint64_t> room((flags.bytes + 7) / 8, 0);
    auto* reported = reinterpret_cast<VkBaseOutStructure*>(room.data());
    reported->sType = wanted.sType;
    VkPhysicalDeviceFeatures2 query{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, reported, {}};
    getFeatures2(physical, &query);
    const FeatureFlags have = flagsOf(*reinterpret_cast<const VkBaseInStructure*>(reported));
    for (size_t i = 0; i < flags.count; ++i)
        if (flags.first[i] && !have.first[i])
            return refuse("vkCreateDevice enables boolean %zu of the feature structure %d, which the device does not report", i,
                          int(wanted.sType));
    return VK_SUCCESS;
}

VkResult checkFeatures(VkPhysicalDevice physical, const VkPhysicalDeviceFeatures& wanted) {
    VkPhysicalDeviceFeatures reported{};
    getFeatures(physical, &reported);
    const auto *want = reinterpret_cast<const VkBool32*>(&wanted), *have = reinterpret_cast<const VkBool32*>(&reported);
    for (size_t i = 0; i < sizeof wanted / sizeof(VkBool32); ++i)
        if (want[i] && !have[i])
            return refuse("vkCreateDevice enables member %zu of VkPhysicalDeviceFeatures, which the device does not report", i);
    return VK_SUCCESS;
}

/** Refuses features that the phone does not report, and notes in `device` what is enabled. (Vulkan's loader refuses the extensions.) */
VkResult checkDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo& info, Device& device) {
    const VkPhysicalDeviceFeatures* core = info.pEnabledFeatures;
    for (auto* at = static_cast<const VkBaseInStructure*>(info.pNext); at; at = at->pNext) {
        if (at->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2) {
            core = &reinterpret_cast<const VkPhysicalDeviceFeatures2*>(at)->features;
            continue;
        }
        if (const VkResult result = checkFlags(physical, *at); result != VK_SUCCESS) return result;
        switch (at->sType) {
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES:
                device.multiview = reinterpret_cast<const VkPhysicalDeviceMultiviewFeatures*>(at)->multiview;
                break;
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES:
                device.storage16 = reinterpret_cast<const VkPhysicalDevice16BitStorageFeatures*>(at)->storageBuffer16BitAccess;
                break;
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_8BIT_STORAGE_FEATURES:
                device.storage8 = reinterpret_cast<const VkPhysicalDevice8BitStorageFeatures*>(at)->storageBuffer8BitAccess;
                break;
            case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DRAW_PARAMETERS_FEATURES:
                device.drawParameters = reinterpret_cast<const VkPhysicalDeviceShaderDrawParametersFeatures*>(at)->shaderDrawParameters;
                break;
            default:
                break;
        }
    }
    if (core) device.features = *core;
    return core ? checkFeatures(physical, *core) : VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkDevice* device) {
    auto* link = linkIn<VkLayerDeviceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    auto made = std::make_shared<Device>();
    if (const VkResult result = checkDevice(physical, *info, *made); result != VK_SUCCESS) return result;
    made->subgroups.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &made->subgroups, {}};
    getProperties2(physical, &properties);
    made->limits = properties.properties.limits;

    const auto nextInstanceProc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    made->nextProc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(nextInstanceProc(instanceOf(physical)->handle, "vkCreateDevice"));
    if (!create) return VK_ERROR_INITIALIZATION_FAILED;
    if (const VkResult result = create(physical, info, allocator, device); result != VK_SUCCESS) return result;
    made->handle = *device;
#define DPL_LOAD(name) made->name = reinterpret_cast<PFN_##name>(made->nextProc(*device, #name));
    DPL_NEXT_DEVICE(DPL_LOAD)
#undef DPL_LOAD
    std::lock_guard lock(tablesMutex);
    devices[keyOf(*device)] = made;
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroyDevice(VkDevice device, const VkAllocationCallbacks* allocator) {
    if (!device) return;
    const auto gone = deviceOf(device);
    void* const key = keyOf(device);
    gone->vkDestroyDevice(device, allocator);
    std::lock_guard lock(tablesMutex);
    devices.erase(key);
}

// ── what goes beyond it ─────────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR VkResult VKAPI_CALL createBuffer(VkDevice device, const VkBufferCreateInfo* info, const VkAllocationCallbacks* allocator,
                                            VkBuffer* buffer) {
    const auto d = deviceOf(device);
    const VkResult result = d->vkCreateBuffer(device, info, allocator, buffer);
    if (result == VK_SUCCESS) {
        std::lock_guard lock(d->mutex);
        d->bufferBytes[*buffer] = info->size;
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL destroyBuffer(VkDevice device, VkBuffer buffer, const VkAllocationCallbacks* allocator) {
    const auto d = deviceOf(device);
    {
        std::lock_guard lock(d->mutex);
        d->bufferBytes.erase(buffer);
    }
    d->vkDestroyBuffer(device, buffer, allocator);
}

VKAPI_ATTR VkResult VKAPI_CALL createSetLayout(VkDevice device, const VkDescriptorSetLayoutCreateInfo* info,
                                               const VkAllocationCallbacks* allocator, VkDescriptorSetLayout* layout) {
    const auto d = deviceOf(device);
    const VkResult result = d->vkCreateDescriptorSetLayout(device, info, allocator, layout);
    if (result == VK_SUCCESS) {
        std::lock_guard lock(d->mutex);
        d->setLayouts[*layout].assign(info->pBindings, info->pBindings + info->bindingCount);
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL destroySetLayout(VkDevice device, VkDescriptorSetLayout layout, const VkAllocationCallbacks* allocator) {
    const auto d = deviceOf(device);
    {
        std::lock_guard lock(d->mutex);
        d->setLayouts.erase(layout);
    }
    d->vkDestroyDescriptorSetLayout(device, layout, allocator);
}

struct StageCount {
    const char* what;
    uint32_t limit;
    bool (*counts)(VkDescriptorType type);
};

VKAPI_ATTR VkResult VKAPI_CALL createPipelineLayout(VkDevice device, const VkPipelineLayoutCreateInfo* info,
                                                    const VkAllocationCallbacks* allocator, VkPipelineLayout* layout) {
    const auto d = deviceOf(device);
    const StageCount counts[] = {
        {"storage buffers", d->limits.maxPerStageDescriptorStorageBuffers,
         [](VkDescriptorType t) { return t == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || t == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC; }},
        {"uniform buffers", d->limits.maxPerStageDescriptorUniformBuffers,
         [](VkDescriptorType t) { return t == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER || t == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC; }},
        {"storage images and storage texel buffers", d->limits.maxPerStageDescriptorStorageImages,
         [](VkDescriptorType t) { return t == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE || t == VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER; }},
        {"sampled images", d->limits.maxPerStageDescriptorSampledImages,
         [](VkDescriptorType t) {
             return t == VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE || t == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ||
                    t == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
         }},
    };
    if (info->setLayoutCount > d->limits.maxBoundDescriptorSets)
        return refuse("vkCreatePipelineLayout has %u descriptor sets, the device reports %u", info->setLayoutCount,
                      d->limits.maxBoundDescriptorSets);
    {
        std::lock_guard lock(d->mutex);
        for (const StageCount& count : counts)
            for (uint32_t stage = VK_SHADER_STAGE_VERTEX_BIT; stage <= VK_SHADER_STAGE_COMPUTE_BIT; stage <<= 1) {
                uint32_t used = 0;
                for (uint32_t s = 0; s < info->setLayoutCount; ++s)
                    for (const VkDescriptorSetLayoutBinding& binding : d->setLayouts[info->pSetLayouts[s]])
                        if ((binding.stageFlags & stage) && count.counts(binding.descriptorType)) used += binding.descriptorCount;
                if (used > count.limit)
                    return refuse("vkCreatePipelineLayout has %u %s in shader stage 0x%x, the device reports %u", used, count.what, stage,
                                  count.limit);
            }
    }
    for (uint32_t i = 0; i < info->pushConstantRangeCount; ++i) {
        const VkPushConstantRange& range = info->pPushConstantRanges[i];
        if (range.offset + range.size > d->limits.maxPushConstantsSize)
            return refuse("vkCreatePipelineLayout has push constants up to byte %u, the device reports %u", range.offset + range.size,
                          d->limits.maxPushConstantsSize);
    }
    return d->vkCreatePipelineLayout(device, info, allocator, layout);
}

/** What a SPIR-V capability needs and the device was not created with; null if nothing is missing. */
const char* missing(uint32_t capability, const Device& d) {
    const auto subgroup = [&](VkSubgroupFeatureFlags operation) {
        return d.subgroups.supportedOperations & operation ? nullptr : "subgroup operations";
    };
    const auto feature = [](bool enabled, const char* name) { return enabled ? nullptr : name; };
    switch (capability) {
        case 0:   // Matrix
        case 1:   // Shader
        case 43:  // Sampled1D
        case 44:  // Image1D
        case 46:  // SampledBuffer
        case 47:  // ImageBuffer
        case 50:  // ImageQuery
        case 51:  // DerivativeControl
            return nullptr;
        case 9:
            return "shaderFloat16";
        case 10:
            return feature(d.features.shaderFloat64, "shaderFloat64");
        case 11:
            return feature(d.features.shaderInt64, "shaderInt64");
        case 22:
            return feature(d.features.shaderInt16, "shaderInt16");
        case 35:
            return feature(d.features.sampleRateShading, "sampleRateShading");
        case 39:
            return "shaderInt8";
        case 49:
            return feature(d.features.shaderStorageImageExtendedFormats, "shaderStorageImageExtendedFormats");
        case 61:
            return subgroup(VK_SUBGROUP_FEATURE_BASIC_BIT);
        case 62:
            return subgroup(VK_SUBGROUP_FEATURE_VOTE_BIT);
        case 63:
            return subgroup(VK_SUBGROUP_FEATURE_ARITHMETIC_BIT);
        case 64:
            return subgroup(VK_SUBGROUP_FEATURE_BALLOT_BIT);
        case 65:
            return subgroup(VK_SUBGROUP_FEATURE_SHUFFLE_BIT);
        case 66:
            return subgroup(VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT);
        case 67:
            return subgroup(VK_SUBGROUP_FEATURE_CLUSTERED_BIT);
        case 68:
            return subgroup(VK_SUBGROUP_FEATURE_QUAD_BIT);
        case 4427:
            return feature(d.drawParameters, "shaderDrawParameters");
        case 4433:
            return feature(d.storage16, "storageBuffer16BitAccess");
        case 4439:
            return feature(d.multiview, "multiview");
        case 4448:
            return feature(d.storage8, "storageBuffer8BitAccess");
        default:
            return "a capability that tests/limits/limits_layer.cpp does not know";
    }
}

VKAPI_ATTR VkResult VKAPI_CALL createShaderModule(VkDevice device, const VkShaderModuleCreateInfo* info,
                                                  const VkAllocationCallbacks* allocator, VkShaderModule* module) {
    const auto d = deviceOf(device);
    const SpirvNeeds needs = needsOf({info->pCode, info->codeSize / 4});
    for (uint32_t capability : needs.capabilities)
        if (const char* what = missing(capability, *d))
            return refuse("a shader has SPIR-V capability %u; the device is without %s", capability, what);
    const uint64_t lanes = uint64_t(needs.groupLanes[0]) * needs.groupLanes[1] * needs.groupLanes[2];
    if (lanes > d->limits.maxComputeWorkGroupInvocations)
        return refuse("a shader has workgroups of %llu invocations, the device reports %u", static_cast<unsigned long long>(lanes),
                      d->limits.maxComputeWorkGroupInvocations);
    return d->vkCreateShaderModule(device, info, allocator, module);
}

VKAPI_ATTR VkResult VKAPI_CALL createGraphicsPipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                       const VkGraphicsPipelineCreateInfo* infos, const VkAllocationCallbacks* allocator,
                                                       VkPipeline* pipelines) {
    const auto d = deviceOf(device);
    for (uint32_t i = 0; i < count; ++i)
        if (infos[i].pMultisampleState && infos[i].pMultisampleState->sampleShadingEnable && !d->features.sampleRateShading)
            return refuse("a pipeline shades single samples; the device is without sampleRateShading");
    return d->vkCreateGraphicsPipelines(device, cache, count, infos, allocator, pipelines);
}

VKAPI_ATTR VkResult VKAPI_CALL createRenderPass(VkDevice device, const VkRenderPassCreateInfo* info, const VkAllocationCallbacks* allocator,
                                                VkRenderPass* pass) {
    const auto d = deviceOf(device);
    for (auto* at = static_cast<const VkBaseInStructure*>(info->pNext); at; at = at->pNext) {
        if (at->sType != VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO || d->multiview) continue;
        const auto& views = *reinterpret_cast<const VkRenderPassMultiviewCreateInfo*>(at);
        if (std::any_of(views.pViewMasks, views.pViewMasks + views.subpassCount, [](uint32_t mask) { return mask != 0; }))
            return refuse("a render pass has views; the device is without multiview");
    }
    return d->vkCreateRenderPass(device, info, allocator, pass);
}

VKAPI_ATTR void VKAPI_CALL updateDescriptorSets(VkDevice device, uint32_t writeCount, const VkWriteDescriptorSet* writes,
                                                uint32_t copyCount, const VkCopyDescriptorSet* copies) {
    const auto d = deviceOf(device);
    for (uint32_t w = 0; w < writeCount; ++w) {
        const VkDescriptorType type = writes[w].descriptorType;
        const bool storage = type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC;
        if (!storage && type != VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER && type != VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC) continue;
        const uint32_t limit = storage ? d->limits.maxStorageBufferRange : d->limits.maxUniformBufferRange;
        for (uint32_t i = 0; i < writes[w].descriptorCount; ++i) {
            const VkDescriptorBufferInfo& bound = writes[w].pBufferInfo[i];
            std::lock_guard lock(d->mutex);
            const VkDeviceSize range = bound.range != VK_WHOLE_SIZE ? bound.range : d->bufferBytes[bound.buffer] - bound.offset;
            if (range <= limit) continue;
            refuse("a descriptor binds %llu bytes of a %s buffer, the device reports %u", static_cast<unsigned long long>(range),
                   storage ? "storage" : "uniform", limit);
            d->broken = true;
        }
    }
    d->vkUpdateDescriptorSets(device, writeCount, writes, copyCount, copies);
}

void checkGroups(Device& d, uint32_t x, uint32_t y, uint32_t z) {
    const uint32_t groups[] = {x, y, z};
    for (int axis = 0; axis < 3; ++axis)
        if (groups[axis] > d.limits.maxComputeWorkGroupCount[axis]) {
            refuse("a dispatch has %u workgroups along %c, the device reports %u", groups[axis], "xyz"[axis],
                   d.limits.maxComputeWorkGroupCount[axis]);
            d.broken = true;
        }
}

VKAPI_ATTR void VKAPI_CALL cmdDispatch(VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
    const auto d = deviceOf(commands);
    checkGroups(*d, x, y, z);
    d->vkCmdDispatch(commands, x, y, z);
}

VKAPI_ATTR void VKAPI_CALL cmdDispatchBase(VkCommandBuffer commands, uint32_t baseX, uint32_t baseY, uint32_t baseZ, uint32_t x, uint32_t y,
                                           uint32_t z) {
    const auto d = deviceOf(commands);
    checkGroups(*d, x, y, z);
    d->vkCmdDispatchBase(commands, baseX, baseY, baseZ, x, y, z);
}

void checkDrawCount(Device& d, uint32_t drawCount) {
    if (drawCount <= 1) return;  // more need the feature multiDrawIndirect, which the phone never reports
    refuse("an indirect draw has %u draws; the device is without multiDrawIndirect", drawCount);
    d.broken = true;
}

VKAPI_ATTR void VKAPI_CALL cmdDrawIndirect(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset, uint32_t drawCount,
                                           uint32_t stride) {
    const auto d = deviceOf(commands);
    checkDrawCount(*d, drawCount);
    d->vkCmdDrawIndirect(commands, buffer, offset, drawCount, stride);
}

VKAPI_ATTR void VKAPI_CALL cmdDrawIndexedIndirect(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset, uint32_t drawCount,
                                                  uint32_t stride) {
    const auto d = deviceOf(commands);
    checkDrawCount(*d, drawCount);
    d->vkCmdDrawIndexedIndirect(commands, buffer, offset, drawCount, stride);
}

VKAPI_ATTR void VKAPI_CALL cmdWriteTimestamp(VkCommandBuffer commands, VkPipelineStageFlagBits stage, VkQueryPool pool, uint32_t query) {
    const auto d = deviceOf(commands);
    refuse("a timestamp is written; the queue family reports no valid bits");
    d->broken = true;
    d->vkCmdWriteTimestamp(commands, stage, pool, query);
}

VKAPI_ATTR VkResult VKAPI_CALL endCommandBuffer(VkCommandBuffer commands) {
    const auto d = deviceOf(commands);
    const VkResult result = d->vkEndCommandBuffer(commands);
    return d->broken.exchange(false) ? kRefused : result;
}

VKAPI_ATTR VkResult VKAPI_CALL queueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo* submits, VkFence fence) {
    const auto d = deviceOf(queue);
    return d->broken.exchange(false) ? kRefused : d->vkQueueSubmit(queue, count, submits, fence);
}

// ── the way in ──────────────────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProc(VkInstance instance, const char* name);
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProc(VkDevice device, const char* name);

PFN_vkVoidFunction ownInstanceFunction(const char* name) {
    return find({{"vkGetInstanceProcAddr", untyped(getInstanceProc)},
                 {"vkCreateInstance", untyped(createInstance)},
                 {"vkDestroyInstance", untyped(destroyInstance)},
                 {"vkCreateDevice", untyped(createDevice)},
                 {"vkEnumerateDeviceExtensionProperties", untyped(getDeviceExtensions)},
                 {"vkGetPhysicalDeviceProperties", untyped(getProperties)},
                 {"vkGetPhysicalDeviceProperties2", untyped(getProperties2)},
                 {"vkGetPhysicalDeviceProperties2KHR", untyped(getProperties2)},
                 {"vkGetPhysicalDeviceFeatures", untyped(getFeatures)},
                 {"vkGetPhysicalDeviceFeatures2", untyped(getFeatures2)},
                 {"vkGetPhysicalDeviceFeatures2KHR", untyped(getFeatures2)},
                 {"vkGetPhysicalDeviceFormatProperties", untyped(getFormat)},
                 {"vkGetPhysicalDeviceFormatProperties2", untyped(getFormat2)},
                 {"vkGetPhysicalDeviceFormatProperties2KHR", untyped(getFormat2)},
                 {"vkGetPhysicalDeviceQueueFamilyProperties", untyped(getQueueFamilies)},
                 {"vkGetPhysicalDeviceQueueFamilyProperties2", untyped(getQueueFamilies2)},
                 {"vkGetPhysicalDeviceQueueFamilyProperties2KHR", untyped(getQueueFamilies2)}},
                name);
}

PFN_vkVoidFunction ownDeviceFunction(const char* name) {
    return find({{"vkGetDeviceProcAddr", untyped(getDeviceProc)},
                 {"vkDestroyDevice", untyped(destroyDevice)},
                 {"vkCreateBuffer", untyped(createBuffer)},
                 {"vkDestroyBuffer", untyped(destroyBuffer)},
                 {"vkCreateDescriptorSetLayout", untyped(createSetLayout)},
                 {"vkDestroyDescriptorSetLayout", untyped(destroySetLayout)},
                 {"vkCreatePipelineLayout", untyped(createPipelineLayout)},
                 {"vkCreateShaderModule", untyped(createShaderModule)},
                 {"vkCreateGraphicsPipelines", untyped(createGraphicsPipelines)},
                 {"vkCreateRenderPass", untyped(createRenderPass)},
                 {"vkUpdateDescriptorSets", untyped(updateDescriptorSets)},
                 {"vkCmdDispatch", untyped(cmdDispatch)},
                 {"vkCmdDispatchBase", untyped(cmdDispatchBase)},
                 {"vkCmdDrawIndirect", untyped(cmdDrawIndirect)},
                 {"vkCmdDrawIndexedIndirect", untyped(cmdDrawIndexedIndirect)},
                 {"vkCmdWriteTimestamp", untyped(cmdWriteTimestamp)},
                 {"vkEndCommandBuffer", untyped(endCommandBuffer)},
                 {"vkQueueSubmit", untyped(queueSubmit)}},
                name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProc(VkDevice device, const char* name) {
    if (const auto own = ownDeviceFunction(name)) return own;
    return deviceOf(device)->nextProc(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProc(VkInstance instance, const char* name) {
    if (const auto own = ownInstanceFunction(name)) return own;
    if (const auto own = ownDeviceFunction(name)) return own;
    return instance ? instanceOf(instance)->nextProc(instance, name) : nullptr;
}

}  // namespace
}  // namespace dpl::limits

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
    if (!version || version->sType != LAYER_NEGOTIATE_INTERFACE_STRUCT || version->loaderLayerInterfaceVersion < 2)
        return VK_ERROR_INITIALIZATION_FAILED;
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = dpl::limits::getInstanceProc;
    version->pfnGetDeviceProcAddr = dpl::limits::getDeviceProc;
    version->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
