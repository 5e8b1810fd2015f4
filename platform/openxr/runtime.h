// SPDX-License-Identifier: Apache-2.0
// An OpenXR runtime and what lives as long as the program: instance, system, a Vulkan device made through the runtime
// (XR_KHR_vulkan_enable2), and a Doppel context on that device. Sessions come and go on top (session.h); avatars stay.
//
//   auto runtime = dpl::xr::Runtime::create({});
//   dpl::xr::Session session(**runtime, {});
//   while (...) session.frame(scene);
//
// One thread drives a runtime and its session. Errors are sentences; nothing throws except std::bad_alloc while something is created.
#pragma once

#include <doppel/doppel_vulkan.h>
#include <vulkan/vulkan.h>

#include <doppel/doppel.hpp>
#include <memory>
#include <string>
#include <vector>

#include "platform/openxr/openxr.h"

namespace dpl::xr {

using doppel::Error;
using doppel::Result;
using doppel::Status;

struct RuntimeOptions {
    std::string applicationName = "doppel";
    bool validate = false;  // with the Vulkan validation layer, which must be installed; see Runtime::complaints
    /** What a platform needs for an instance; on Android, see android_loader.h. Read by Runtime::create. */
    std::vector<const char*> instanceExtensions;
    const void* instanceNext = nullptr;  // chain of XrInstanceCreateInfo
};

/** Optional OpenXR extensions that the runtime has and that were enabled. */
struct Extensions {
    bool depthLayer = false;    // XR_KHR_composition_layer_depth
    bool refreshRate = false;   // XR_FB_display_refresh_rate
    bool quadViews = false;     // XR_VARJO_quad_views
    bool localFloor = false;    // XR_EXT_local_floor
    bool passthrough = false;   // XR_FB_passthrough
    bool handTracking = false;  // XR_EXT_hand_tracking
    bool bodyTracking = false;  // XR_FB_body_tracking
};

class Runtime {
public:
    /** DPL_ERROR_UNSUPPORTED: no runtime is installed or running, it lacks XR_KHR_vulkan_enable2, or no GPU fits; the text says which. */
    static Result<std::unique_ptr<Runtime>> create(const RuntimeOptions& options);
    ~Runtime();
    Runtime(const Runtime&) = delete;
    Runtime& operator=(const Runtime&) = delete;

    /** Lives as long as the runtime. Load avatars with it and destroy them before. */
    DplContext context() const { return context_; }
    const std::string& name() const { return name_; }  // for people: "Monado(XRT) by Collabora et al '25.0.0' on llvmpipe"
    /** Warnings and errors of the Vulkan validation layer so far; at most the first 20 are kept. */
    size_t complaintCount() const { return complaintCount_; }
    const std::vector<std::string>& complaints() const { return complaints_; }

    XrInstance instance() const { return instance_; }
    const Extensions& extensions() const { return extensions_; }
    VkInstance vulkan() const { return vulkan_; }
    VkPhysicalDevice physicalDevice() const { return physical_; }
    VkDevice device() const { return device_; }
    VkQueue queue() const { return queue_; }
    uint32_t queueFamily() const { return family_; }
    bool multiview() const { return multiview_; }  // the device has it and Doppel's composers accept it

    /** Finds the headset. A runtime may lose it and get it back, under another id. DPL_ERROR_NOT_FOUND: not there at present; try again.
     *  DPL_ERROR_UNSUPPORTED: it would need another GPU than the one that the program runs on. */
    Result<XrSystemId> findSystem();
    /** "xrWaitFrame failed: XR_ERROR_SESSION_LOST". */
    Error failed(XrResult result, const char* call) const;
    /** A function of an extension, or null. */
    template <class F>
    F function(const char* name) const {
        return reinterpret_cast<F>(functionNamed(name));
    }
    /** Index of a memory type with these properties, or an error. */
    Result<uint32_t> memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const;

private:
    Runtime() = default;
    Status createInstance(const RuntimeOptions& options);
    Status createVulkan(const RuntimeOptions& options);
    Status createDevice(const RuntimeOptions& options);
    Status createContext();
    void findMultiview();
    PFN_xrVoidFunction functionNamed(const char* name) const;
    static VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                                    const VkDebugUtilsMessengerCallbackDataEXT*, void* user);

    XrInstance instance_ = XR_NULL_HANDLE;
    XrSystemId system_ = XR_NULL_SYSTEM_ID;
    Extensions extensions_;
    std::string name_;
    VkInstance vulkan_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t family_ = 0;
    VkPhysicalDeviceMultiviewFeatures multiviewFeatures_{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    VkPhysicalDeviceFeatures2 enabled_{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    bool multiview_ = false;
    DplContext context_ = nullptr;
    size_t complaintCount_ = 0;
    std::vector<std::string> complaints_;
};

}  // namespace dpl::xr
