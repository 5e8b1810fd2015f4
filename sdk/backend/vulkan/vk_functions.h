// SPDX-License-Identifier: Apache-2.0
// The Vulkan functions that the backend calls, as a table for one instance and one device. Nothing here links to libvulkan.
//
// The table belongs to one device, because an app may bring its own vkGetInstanceProcAddr and two contexts may use two loaders. The
// library volk (in Debian 12's version) does not fit: it keeps the instance functions in global variables that are named like the
// functions, which also clash in a program that links libvulkan and the static libdoppel.
#pragma once

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include "sdk/core/result.h"

// Called before there is an instance.
#define DPL_VK_GLOBAL_FUNCTIONS(DO) DO(vkCreateInstance) DO(vkEnumerateInstanceLayerProperties) DO(vkEnumerateInstanceVersion)

// Called with an instance or a physical device.
#define DPL_VK_INSTANCE_FUNCTIONS(DO)       \
    DO(vkCreateDevice)                      \
    DO(vkDestroyInstance)                   \
    DO(vkEnumeratePhysicalDevices)          \
    DO(vkGetDeviceProcAddr)                 \
    DO(vkGetPhysicalDeviceFeatures2)        \
    DO(vkGetPhysicalDeviceFormatProperties) \
    DO(vkGetPhysicalDeviceMemoryProperties) \
    DO(vkGetPhysicalDeviceProperties)       \
    DO(vkGetPhysicalDeviceProperties2)      \
    DO(vkGetPhysicalDeviceQueueFamilyProperties)

// Of VK_EXT_debug_utils: null unless the instance was made with it.
#define DPL_VK_DEBUG_FUNCTIONS(DO) DO(vkCreateDebugUtilsMessengerEXT) DO(vkDestroyDebugUtilsMessengerEXT)

// Called with a device, a queue or a command buffer.
#define DPL_VK_DEVICE_FUNCTIONS(DO)   \
    DO(vkAllocateCommandBuffers)      \
    DO(vkAllocateDescriptorSets)      \
    DO(vkAllocateMemory)              \
    DO(vkBeginCommandBuffer)          \
    DO(vkBindBufferMemory)            \
    DO(vkBindImageMemory)             \
    DO(vkCmdBeginRenderPass)          \
    DO(vkCmdBindDescriptorSets)       \
    DO(vkCmdBindPipeline)             \
    DO(vkCmdBlitImage)                \
    DO(vkCmdCopyBuffer)               \
    DO(vkCmdCopyImageToBuffer)        \
    DO(vkCmdDispatch)                 \
    DO(vkCmdDispatchIndirect)         \
    DO(vkCmdDraw)                     \
    DO(vkCmdDrawIndirect)             \
    DO(vkCmdEndRenderPass)            \
    DO(vkCmdFillBuffer)               \
    DO(vkCmdPipelineBarrier)          \
    DO(vkCmdPushConstants)            \
    DO(vkCmdResetQueryPool)           \
    DO(vkCmdSetScissor)               \
    DO(vkCmdSetViewport)              \
    DO(vkCmdWriteTimestamp)           \
    DO(vkCreateBuffer)                \
    DO(vkCreateBufferView)            \
    DO(vkCreateCommandPool)           \
    DO(vkCreateComputePipelines)      \
    DO(vkCreateDescriptorPool)        \
    DO(vkCreateDescriptorSetLayout)   \
    DO(vkCreateFence)                 \
    DO(vkCreateFramebuffer)           \
    DO(vkCreateGraphicsPipelines)     \
    DO(vkCreateImage)                 \
    DO(vkCreateImageView)             \
    DO(vkCreatePipelineLayout)        \
    DO(vkCreateQueryPool)             \
    DO(vkCreateRenderPass)            \
    DO(vkCreateShaderModule)          \
    DO(vkDestroyBuffer)               \
    DO(vkDestroyBufferView)           \
    DO(vkDestroyCommandPool)          \
    DO(vkDestroyDescriptorPool)       \
    DO(vkDestroyDescriptorSetLayout)  \
    DO(vkDestroyDevice)               \
    DO(vkDestroyFence)                \
    DO(vkDestroyFramebuffer)          \
    DO(vkDestroyImage)                \
    DO(vkDestroyImageView)            \
    DO(vkDestroyPipeline)             \
    DO(vkDestroyPipelineLayout)       \
    DO(vkDestroyQueryPool)            \
    DO(vkDestroyRenderPass)           \
    DO(vkDestroyShaderModule)         \
    DO(vkEndCommandBuffer)            \
    DO(vkFreeMemory)                  \
    DO(vkGetBufferMemoryRequirements) \
    DO(vkGetDeviceQueue)              \
    DO(vkGetFenceStatus)              \
    DO(vkGetImageMemoryRequirements)  \
    DO(vkGetQueryPoolResults)         \
    DO(vkMapMemory)                   \
    DO(vkQueueSubmit)                 \
    DO(vkResetCommandBuffer)          \
    DO(vkResetFences)                 \
    DO(vkUpdateDescriptorSets)        \
    DO(vkWaitForFences)

namespace dpl::vk {

/** Filled in three steps, in the order below. A step fails with Code::Unsupported and names the missing function. */
struct Functions {
    PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr = nullptr;  // from findVulkanLoader() or from the app
#define DPL_VK_MEMBER(name) PFN_##name name = nullptr;
    DPL_VK_GLOBAL_FUNCTIONS(DPL_VK_MEMBER)
    DPL_VK_INSTANCE_FUNCTIONS(DPL_VK_MEMBER)
    DPL_VK_DEBUG_FUNCTIONS(DPL_VK_MEMBER)
    DPL_VK_DEVICE_FUNCTIONS(DPL_VK_MEMBER)
#undef DPL_VK_MEMBER

    Status loadGlobal(PFN_vkGetInstanceProcAddr getInstanceProcAddr);
    Status loadInstance(VkInstance instance);
    Status loadDevice(VkDevice device);  // pointers into the driver, which skip the loader's dispatch
};

}  // namespace dpl::vk
