// SPDX-License-Identifier: Apache-2.0
#include "platform/common/errors.h"

namespace dpl::platform {

Error vulkanError(VkResult result, const char* call) {
    const std::string text = call, of = " (" + text.substr(0, text.find('(')) + ")";
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return {DPL_ERROR_OUT_OF_MEMORY, "out of memory" + of};
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return {DPL_ERROR_OUT_OF_MEMORY, "out of graphics memory" + of};
        case VK_ERROR_DEVICE_LOST:
            return {DPL_ERROR_DEVICE, "the graphics device was lost" + of};
        case VK_ERROR_SURFACE_LOST_KHR:
            return {DPL_ERROR_NOT_FOUND, "the window's surface was lost" + of};
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return {DPL_ERROR_UNSUPPORTED, "no Vulkan driver is installed" + of};
        default: {
            const bool taken = result == VK_ERROR_NATIVE_WINDOW_IN_USE_KHR;
            return {taken ? DPL_ERROR_NOT_FOUND : DPL_ERROR_INTERNAL, "Vulkan failed with code " + std::to_string(int(result)) + of};
        }
    }
}

}  // namespace dpl::platform
