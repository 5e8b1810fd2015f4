// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/vulkan/vk_loader.h"

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace dpl::vk {
namespace {

// In the order they are tried.
#if defined(_WIN32)
constexpr const char* kLibraries[] = {"vulkan-1.dll"};
#elif defined(__APPLE__)
constexpr const char* kLibraries[] = {"libvulkan.1.dylib", "libvulkan.dylib", "libMoltenVK.dylib"};
#elif defined(__ANDROID__)
constexpr const char* kLibraries[] = {"libvulkan.so"};
#else
constexpr const char* kLibraries[] = {"libvulkan.so.1"};
#endif

/** The address of vkGetInstanceProcAddr in a library, null when the library is missing or does not export it. */
void* entryPoint(const char* library) {
    constexpr const char* kEntryPoint = "vkGetInstanceProcAddr";
#if defined(_WIN32)
    const HMODULE handle = LoadLibraryA(library);
    return handle ? reinterpret_cast<void*>(GetProcAddress(handle, kEntryPoint)) : nullptr;
#else
    void* handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    return handle ? dlsym(handle, kEntryPoint) : nullptr;
#endif
}

}  // namespace

Result<PFN_vkGetInstanceProcAddr> findVulkanLoader() {
    for (const char* library : kLibraries)
        if (void* address = entryPoint(library)) return reinterpret_cast<PFN_vkGetInstanceProcAddr>(address);
    return fail(Code::Unsupported, "the Vulkan loader {} is not installed", kLibraries[0]);
}

}  // namespace dpl::vk
