// SPDX-License-Identifier: Apache-2.0
// Errors of a shell are values: a code and a sentence for a human, as those of the SDK. Nothing here throws but std::bad_alloc.
#pragma once

#include <vulkan/vulkan.h>

#include <doppel/doppel.hpp>

namespace dpl::platform {

using doppel::Error;
using doppel::Result;
using doppel::Status;

/** Why a call of Vulkan failed. call: its name, or its text, of which the name is taken. The code says who can help:
 *  DPL_ERROR_DEVICE         the device is lost; another one may do
 *  DPL_ERROR_NOT_FOUND      the window's surface is gone, or an earlier one still has the window; another one may do
 *  DPL_ERROR_OUT_OF_MEMORY  of the CPU or of the GPU
 *  DPL_ERROR_UNSUPPORTED    no driver is installed
 *  DPL_ERROR_INTERNAL       anything else */
Error vulkanError(VkResult result, const char* call);

}  // namespace dpl::platform

/** Returns the error of a call of Vulkan, if it has one, from the calling function. */
#define DPL_VK(call) \
    if (const VkResult vkResult = (call); vkResult != VK_SUCCESS) return ::dpl::platform::vulkanError(vkResult, #call)
/** The same for create(parent, &info, nullptr, &handle). After an error `handle` is null: what a failed call writes is undefined. */
#define DPL_VK_MAKE(handle, create, parent, info)                                                        \
    if (const VkResult vkResult = create(parent, &(info), nullptr, &(handle)); vkResult != VK_SUCCESS) { \
        (handle) = VK_NULL_HANDLE;                                                                       \
        return ::dpl::platform::vulkanError(vkResult, #create);                                          \
    }
/** The same for a Status. */
#define DPL_SHELL_OK(...) \
    if (::doppel::Status shellStatus = (__VA_ARGS__); !shellStatus) return shellStatus.error()
/** The same for a Result. target: a variable, or the declaration of one, that takes the value. */
#define DPL_SHELL_TRY(target, ...)                                                \
    auto DPL_SHELL_LINE(shellResult) = (__VA_ARGS__);                             \
    if (!DPL_SHELL_LINE(shellResult)) return DPL_SHELL_LINE(shellResult).error(); \
    target = std::move(*DPL_SHELL_LINE(shellResult))
#define DPL_SHELL_LINE(name) DPL_SHELL_JOIN(name, __LINE__)
#define DPL_SHELL_JOIN(a, b) DPL_SHELL_JOIN_(a, b)
#define DPL_SHELL_JOIN_(a, b) a##b
