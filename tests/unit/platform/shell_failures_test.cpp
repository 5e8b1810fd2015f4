// SPDX-License-Identifier: Apache-2.0
// Every call of Vulkan fails once while the parts of a shell are made. This program's functions stand before those of libvulkan.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "platform/common/frame_slots.h"
#include "platform/common/room.h"
#include "platform/desktop/canvas.h"

namespace dpl::test {
namespace {

struct Faults {
    uint64_t calls = 0, failAt = 0;  // counted from 1; 0: none fails
    VkResult error = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    std::string failed;               // the function
    std::map<std::string, int> live;  // objects by type

    void arm(uint64_t call) { calls = 0, failAt = call, failed.clear(), live.clear(); }
    bool fails(const char* function) {
        if (++calls != failAt) return false;
        failed = function;
        return true;
    }
    std::string leaked() const {
        std::string names;
        for (const auto& [type, count] : live)
            if (count != 0) names += type + " " + std::to_string(count) + " ";
        return names;
    }
};

Faults& faults() {
    static Faults all;
    return all;
}

template <class Function>
Function* next(Function*, const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/** What a failed call writes is undefined; drivers have been seen to leave such a handle. */
template <class Handle>
VkResult spoiled(Handle* handle) {
    *handle = reinterpret_cast<Handle>(uintptr_t(0x6bad6bad));
    return faults().error;
}

}  // namespace
}  // namespace dpl::test

using dpl::test::faults;
using dpl::test::next;

#define CALL(name, PARAMETERS, ...)                             \
    extern "C" VKAPI_ATTR VkResult VKAPI_CALL name PARAMETERS { \
        if (faults().fails(#name)) return faults().error;       \
        return next(&name, #name)(__VA_ARGS__);                 \
    }
#define MADE(type, make, Parent, Info, Handle)                                                                                      \
    extern "C" VKAPI_ATTR VkResult VKAPI_CALL make(Parent parent, const Info* info, const VkAllocationCallbacks* a, Handle* made) { \
        if (faults().fails(#make)) return dpl::test::spoiled(made);                                                                 \
        const VkResult result = next(&make, #make)(parent, info, a, made);                                                          \
        if (result == VK_SUCCESS) ++faults().live[type];                                                                            \
        return result;                                                                                                              \
    }
#define DESTROYED(type, destroy, Handle)                                                                            \
    extern "C" VKAPI_ATTR void VKAPI_CALL destroy(VkDevice device, Handle handle, const VkAllocationCallbacks* a) { \
        if (handle) --faults().live[type];                                                                          \
        next(&destroy, #destroy)(device, handle, a);                                                                \
    }
#define PART(Type)                                                        \
    MADE(#Type, vkCreate##Type, VkDevice, Vk##Type##CreateInfo, Vk##Type) \
    DESTROYED(#Type, vkDestroy##Type, Vk##Type)

PART(Buffer)
PART(CommandPool)
PART(DescriptorPool)
PART(DescriptorSetLayout)
PART(Fence)
PART(Framebuffer)
PART(Image)
PART(ImageView)
PART(PipelineLayout)
PART(RenderPass)
PART(Sampler)
PART(Semaphore)
PART(ShaderModule)
DESTROYED("Pipeline", vkDestroyPipeline, VkPipeline)
MADE("Memory", vkAllocateMemory, VkDevice, VkMemoryAllocateInfo, VkDeviceMemory)
DESTROYED("Memory", vkFreeMemory, VkDeviceMemory)
MADE("Device", vkCreateDevice, VkPhysicalDevice, VkDeviceCreateInfo, VkDevice)
CALL(vkEnumeratePhysicalDevices, (VkInstance i, uint32_t* n, VkPhysicalDevice* out), i, n, out)
CALL(vkEnumerateDeviceExtensionProperties, (VkPhysicalDevice p, const char* l, uint32_t* n, VkExtensionProperties* out), p, l, n, out)
CALL(vkAllocateCommandBuffers, (VkDevice d, const VkCommandBufferAllocateInfo* info, VkCommandBuffer* out), d, info, out)
CALL(vkAllocateDescriptorSets, (VkDevice d, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* out), d, info, out)
CALL(vkBeginCommandBuffer, (VkCommandBuffer c, const VkCommandBufferBeginInfo* info), c, info)
CALL(vkEndCommandBuffer, (VkCommandBuffer c), c)
CALL(vkBindBufferMemory, (VkDevice d, VkBuffer b, VkDeviceMemory m, VkDeviceSize at), d, b, m, at)
CALL(vkBindImageMemory, (VkDevice d, VkImage i, VkDeviceMemory m, VkDeviceSize at), d, i, m, at)
CALL(vkMapMemory, (VkDevice d, VkDeviceMemory m, VkDeviceSize at, VkDeviceSize n, VkMemoryMapFlags f, void** out), d, m, at, n, f, out)
CALL(vkQueueSubmit, (VkQueue q, uint32_t n, const VkSubmitInfo* info, VkFence f), q, n, info, f)
CALL(vkQueueWaitIdle, (VkQueue q), q)

extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkCreateInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* a,
                                                           VkInstance* made) {
    if (faults().fails("vkCreateInstance")) return dpl::test::spoiled(made);
    const VkResult result = next(&vkCreateInstance, "vkCreateInstance")(info, a, made);
    if (result == VK_SUCCESS) ++faults().live["Instance"];
    return result;
}
extern "C" VKAPI_ATTR void VKAPI_CALL vkDestroyInstance(VkInstance instance, const VkAllocationCallbacks* a) {
    if (instance) --faults().live["Instance"];
    next(&vkDestroyInstance, "vkDestroyInstance")(instance, a);
}
extern "C" VKAPI_ATTR void VKAPI_CALL vkDestroyDevice(VkDevice device, const VkAllocationCallbacks* a) {
    if (device) --faults().live["Device"];
    next(&vkDestroyDevice, "vkDestroyDevice")(device, a);
}
extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkCreateGraphicsPipelines(VkDevice d, VkPipelineCache cache, uint32_t count,
                                                                    const VkGraphicsPipelineCreateInfo* infos,
                                                                    const VkAllocationCallbacks* a, VkPipeline* made) {
    for (uint32_t i = 0; i < count; ++i) made[i] = VK_NULL_HANDLE;  // of these calls alone Vulkan says so
    if (faults().fails("vkCreateGraphicsPipelines")) return faults().error;
    const VkResult result = next(&vkCreateGraphicsPipelines, "vkCreateGraphicsPipelines")(d, cache, count, infos, a, made);
    if (result == VK_SUCCESS) faults().live["Pipeline"] += int(count);
    return result;
}

namespace dpl::platform {
namespace {

/** Makes what a shell is made of, but for its window, and lets it go. */
Status makeAndLetGo() {
    DPL_SHELL_TRY(const auto device, Device::create({.applicationName = "shell_failures_test"}));
    DPL_SHELL_TRY(const auto canvas, Canvas::create(*device));
    DPL_SHELL_TRY(const auto room, Room::create(device->handles(), {canvas->roomPass(), 0, kCanvasSamples, 0}));
    DPL_SHELL_TRY(const auto slots, FrameSlots::create(*device));
    DPL_SHELL_OK(canvas->resize({64, 48}));
    return device->runOnce([](VkCommandBuffer) {});
}

TEST(ShellFailures, aCallThatFailsIsNamedAndLeavesNothing) {
    dpl::test::faults().arm(0);
    const Status usual = makeAndLetGo();
    if (!usual && usual.error().code == DPL_ERROR_UNSUPPORTED) GTEST_SKIP() << usual.error().message;
    ASSERT_TRUE(usual) << usual.error().message;
    EXPECT_EQ(faults().leaked(), "");
    const uint64_t calls = faults().calls;
    std::set<std::string> failed;
    for (uint64_t call = 1; call <= calls; ++call) {
        faults().arm(call);
        const Status made = makeAndLetGo();
        failed.insert(faults().failed);
        ASSERT_FALSE(made) << faults().failed;
        EXPECT_EQ(made.error().code, DPL_ERROR_OUT_OF_MEMORY) << faults().failed;
        EXPECT_EQ(made.error().message, "out of graphics memory (" + faults().failed + ")");
        EXPECT_EQ(faults().leaked(), "") << faults().failed;
    }
    EXPECT_EQ(failed.size(), 28u) << "functions that this file wraps";
}

TEST(ShellFailures, sentencesAndCodesOfVulkan) {
    const auto expect = [](VkResult result, DplResult code, const char* sentence) {
        const Error error = vulkanError(result, "vkCall(with, arguments)");
        EXPECT_EQ(error.code, code) << sentence;
        EXPECT_EQ(error.message, sentence);
    };
    expect(VK_ERROR_OUT_OF_HOST_MEMORY, DPL_ERROR_OUT_OF_MEMORY, "out of memory (vkCall)");
    expect(VK_ERROR_OUT_OF_DEVICE_MEMORY, DPL_ERROR_OUT_OF_MEMORY, "out of graphics memory (vkCall)");
    expect(VK_ERROR_DEVICE_LOST, DPL_ERROR_DEVICE, "the graphics device was lost (vkCall)");
    expect(VK_ERROR_SURFACE_LOST_KHR, DPL_ERROR_NOT_FOUND, "the window's surface was lost (vkCall)");
    expect(VK_ERROR_NATIVE_WINDOW_IN_USE_KHR, DPL_ERROR_NOT_FOUND, "Vulkan failed with code -1000000001 (vkCall)");
    expect(VK_ERROR_INCOMPATIBLE_DRIVER, DPL_ERROR_UNSUPPORTED, "no Vulkan driver is installed (vkCall)");
    expect(VK_ERROR_INITIALIZATION_FAILED, DPL_ERROR_INTERNAL, "Vulkan failed with code -3 (vkCall)");
}

}  // namespace
}  // namespace dpl::platform
