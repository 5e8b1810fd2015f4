// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/vulkan/vk_functions.h"

namespace dpl::vk {
namespace {

Status need(bool found, const char* name) {
    return found ? Status() : Status(fail(Code::Unsupported, "the Vulkan driver has no function {}; Doppel needs Vulkan 1.1", name));
}

}  // namespace

Status Functions::loadGlobal(PFN_vkGetInstanceProcAddr getInstanceProcAddr) {
    vkGetInstanceProcAddr = getInstanceProcAddr;
#define DPL_VK_LOAD(name)                                                       \
    name = reinterpret_cast<PFN_##name>(vkGetInstanceProcAddr(nullptr, #name)); \
    DPL_RETURN_IF_ERROR(need(name != nullptr, #name));
    DPL_VK_GLOBAL_FUNCTIONS(DPL_VK_LOAD)
#undef DPL_VK_LOAD
    return {};
}

Status Functions::loadInstance(VkInstance instance) {
#define DPL_VK_LOAD(name) name = reinterpret_cast<PFN_##name>(vkGetInstanceProcAddr(instance, #name));
#define DPL_VK_NEED(name) DPL_RETURN_IF_ERROR(need(name != nullptr, #name));
    DPL_VK_INSTANCE_FUNCTIONS(DPL_VK_LOAD)
    DPL_VK_DEBUG_FUNCTIONS(DPL_VK_LOAD)
    DPL_VK_INSTANCE_FUNCTIONS(DPL_VK_NEED)
#undef DPL_VK_LOAD
    return {};
}

Status Functions::loadDevice(VkDevice device) {
#define DPL_VK_LOAD(name) name = reinterpret_cast<PFN_##name>(vkGetDeviceProcAddr(device, #name));
    DPL_VK_DEVICE_FUNCTIONS(DPL_VK_LOAD)
    DPL_VK_DEVICE_FUNCTIONS(DPL_VK_NEED)
#undef DPL_VK_LOAD
#undef DPL_VK_NEED
    return {};
}

}  // namespace dpl::vk
