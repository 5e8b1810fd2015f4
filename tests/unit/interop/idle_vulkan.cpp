// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/interop/idle_vulkan.h"

#include <atomic>
#include <cstring>

#include "sdk/backend/vulkan/vk_functions.h"

namespace dpl::test {
namespace {

std::atomic<bool> idle = false;

/** Does nothing while idle. Name makes the functions of one type differ. */
template <class Name, class Function>
struct Skipped;
template <class Name, class... Args>
struct Skipped<Name, void(VKAPI_PTR*)(Args...)> {
    static inline void(VKAPI_PTR* real)(Args...) = nullptr;
    static VKAPI_ATTR void VKAPI_CALL call(Args... args) {
        if (!idle.load(std::memory_order_relaxed)) real(args...);
    }
};
template <class Name, class... Args>
struct Skipped<Name, VkResult(VKAPI_PTR*)(Args...)> {
    static inline VkResult(VKAPI_PTR* real)(Args...) = nullptr;
    static VKAPI_ATTR VkResult VKAPI_CALL call(Args... args) { return idle.load(std::memory_order_relaxed) ? VK_SUCCESS : real(args...); }
};

template <class Name, class Function>
PFN_vkVoidFunction over(PFN_vkVoidFunction given) {
    using S = Skipped<Name, Function>;
    S::real = reinterpret_cast<Function>(given);
    return reinterpret_cast<PFN_vkVoidFunction>(S::call);
}

struct Row {
    const char* name;
    PFN_vkVoidFunction (*over)(PFN_vkVoidFunction real);
};
#define DPL_ROW(function) {#function, over<struct Name_##function, PFN_##function>},
constexpr Row kRows[] = {DPL_VK_DEVICE_FUNCTIONS(DPL_ROW)};

/** What a frame calls; the rest makes and frees objects. */
bool isSkipped(const char* name) {
    if (std::strncmp(name, "vkCmd", 5) == 0) return true;
    for (const char* other : {"vkBeginCommandBuffer", "vkEndCommandBuffer", "vkResetCommandBuffer", "vkQueueSubmit", "vkGetFenceStatus",
                              "vkResetFences", "vkWaitForFences"})
        if (std::strcmp(name, other) == 0) return true;
    return false;
}

PFN_vkGetDeviceProcAddr realOfDevice = nullptr;

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL deviceFunction(VkDevice device, const char* name) {
    const PFN_vkVoidFunction real = realOfDevice(device, name);
    if (!real || !isSkipped(name)) return real;
    for (const Row& row : kRows)
        if (std::strcmp(row.name, name) == 0) return row.over(real);
    return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instanceFunction(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction real = vkGetInstanceProcAddr(instance, name);
    if (std::strcmp(name, "vkGetDeviceProcAddr") != 0) return real;
    realOfDevice = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(deviceFunction);
}

}  // namespace

PFN_vkGetInstanceProcAddr idleVulkan() {
    return instanceFunction;
}

void setVulkanIdle(bool now) {
    idle = now;
}

}  // namespace dpl::test
