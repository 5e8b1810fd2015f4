// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/interop/failing_vulkan.h"

#include <cstring>
#include <map>
#include <typeinfo>

#include "sdk/backend/vulkan/vk_functions.h"

namespace dpl::test {
namespace {

constexpr uintptr_t kBadHandle = 0x6bad6bad;

template <class Handle>
uint64_t numberOf(Handle handle) {
    return uint64_t(reinterpret_cast<uintptr_t>(handle));
}

// What a call makes. Command buffers and descriptor sets are freed with their pools.
template <class... Args>
struct Makes {
    static void note(FailingVulkan&, Args...) {}
    static void spoil(Args...) {}
};
template <class Info, class Handle>
struct Makes<VkDevice, const Info*, const VkAllocationCallbacks*, Handle*> {
    static void note(FailingVulkan& vulkan, VkDevice, const Info*, const VkAllocationCallbacks*, Handle* made) {
        vulkan.made(typeid(Handle).name(), numberOf(*made));
    }
    static void spoil(VkDevice, const Info*, const VkAllocationCallbacks*, Handle* made) { *made = reinterpret_cast<Handle>(kBadHandle); }
};
template <class Info>
struct Makes<VkDevice, VkPipelineCache, uint32_t, const Info*, const VkAllocationCallbacks*, VkPipeline*> {
    static void note(FailingVulkan& vulkan, VkDevice, VkPipelineCache, uint32_t count, const Info*, const VkAllocationCallbacks*,
                     VkPipeline* made) {
        for (uint32_t i = 0; i < count; ++i) vulkan.made(typeid(VkPipeline).name(), numberOf(made[i]));
    }
    static void spoil(VkDevice, VkPipelineCache, uint32_t count, const Info*, const VkAllocationCallbacks*, VkPipeline* made) {
        for (uint32_t i = 0; i < count; ++i) made[i] = VK_NULL_HANDLE;  // of these calls alone Vulkan says so
    }
};

/** A function of the table. This case: one that cannot fail and makes nothing. */
template <class Name, class Function>
struct Shim {
    static PFN_vkVoidFunction over(PFN_vkVoidFunction real) { return real; }
};
template <class Name, class... Args>
struct Shim<Name, VkResult(VKAPI_PTR*)(Args...)> {
    static inline VkResult(VKAPI_PTR* real)(Args...) = nullptr;
    static VKAPI_ATTR VkResult VKAPI_CALL call(Args... args) {
        FailingVulkan& vulkan = failingVulkan();
        if (const VkResult error = vulkan.before(Name::text()); error != VK_SUCCESS) {
            Makes<Args...>::spoil(args...);
            if (std::strcmp(Name::text(), "vkEndCommandBuffer") == 0) real(args...);  // a failed one leaves the recording state too
            return error;
        }
        const VkResult result = real(args...);
        if (result == VK_SUCCESS) Makes<Args...>::note(vulkan, args...);
        return result;
    }
    static PFN_vkVoidFunction over(PFN_vkVoidFunction given) {
        real = reinterpret_cast<decltype(real)>(given);
        return reinterpret_cast<PFN_vkVoidFunction>(call);
    }
};
template <class Name, class Handle>
struct Shim<Name, void(VKAPI_PTR*)(VkDevice, Handle, const VkAllocationCallbacks*)> {
    static inline void(VKAPI_PTR* real)(VkDevice, Handle, const VkAllocationCallbacks*) = nullptr;
    static VKAPI_ATTR void VKAPI_CALL call(VkDevice device, Handle handle, const VkAllocationCallbacks* allocator) {
        if (failingVulkan().destroyed(typeid(Handle).name(), numberOf(handle))) real(device, handle, allocator);
    }
    static PFN_vkVoidFunction over(PFN_vkVoidFunction given) {
        real = reinterpret_cast<decltype(real)>(given);
        return reinterpret_cast<PFN_vkVoidFunction>(call);
    }
};

template <class Name, class... Args>
struct Shim<Name, void(VKAPI_PTR*)(VkCommandBuffer, Args...)> {
    static inline void(VKAPI_PTR* real)(VkCommandBuffer, Args...) = nullptr;
    static VKAPI_ATTR void VKAPI_CALL call(VkCommandBuffer commands, Args... args) {
        failingVulkan().record(true);
        real(commands, args...);
        failingVulkan().record(false);
    }
    static PFN_vkVoidFunction over(PFN_vkVoidFunction given) {
        real = reinterpret_cast<decltype(real)>(given);
        return reinterpret_cast<PFN_vkVoidFunction>(call);
    }
};

struct Row {
    const char* name;
    PFN_vkVoidFunction (*over)(PFN_vkVoidFunction real);
};
#define NAME_OF(function)                               \
    struct Name_##function {                            \
        static const char* text() { return #function; } \
    };
DPL_VK_DEVICE_FUNCTIONS(NAME_OF)
#define ROW_OF(function) {#function, Shim<Name_##function, PFN_##function>::over},
constexpr Row kRows[] = {DPL_VK_DEVICE_FUNCTIONS(ROW_OF)};

PFN_vkGetDeviceProcAddr realOfDevice = nullptr;

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL deviceFunction(VkDevice device, const char* name) {
    return failingVulkan().wrapped(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instanceFunction(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction real = vkGetInstanceProcAddr(instance, name);
    if (std::strcmp(name, "vkGetDeviceProcAddr") != 0) return real;
    realOfDevice = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(deviceFunction);
}

/** Functions of the table that Vulkan lets report a lost device, each time. */
bool reportsLoss(const char* function) {
    for (const char* name : {"vkQueueSubmit", "vkWaitForFences", "vkGetFenceStatus", "vkGetQueryPoolResults"})
        if (std::strcmp(function, name) == 0) return true;
    return false;
}

}  // namespace

FailingVulkan& failingVulkan() {
    static FailingVulkan vulkan;
    return vulkan;
}

PFN_vkGetInstanceProcAddr FailingVulkan::entry() {
    return instanceFunction;
}

PFN_vkVoidFunction FailingVulkan::wrapped(VkDevice device, const char* name) {
    device_ = device;
    const PFN_vkVoidFunction real = realOfDevice(device, name);
    for (const Row& row : kRows)
        if (real && std::strcmp(row.name, name) == 0) return row.over(real);
    return real;
}

void FailingVulkan::failAt(uint64_t call, VkResult error, const std::string& function) {
    failAt_ = call, error_ = error, only_ = function;
    calls_.clear(), failed_.clear();
}

VkResult FailingVulkan::before(const char* function) {
    const std::lock_guard lock(mutex_);
    everCalled.insert(function);
    if (std::this_thread::get_id() == watched_) watchedCalls_.push_back(function);
    if (only_.empty() || only_ == function) calls_.push_back(function);
    if (lost_ && reportsLoss(function)) return VK_ERROR_DEVICE_LOST;
    if (!failed_.empty() || calls_.size() != failAt_) return VK_SUCCESS;
    failed_ = function;
    everFailed.insert(function);
    if (error_ == VK_ERROR_DEVICE_LOST) {
        lost_ = true;
        vkDeviceWaitIdle(device_);  // so that the driver and the validation layer, which know of no loss, agree that nothing runs
    }
    return error_;
}

void FailingVulkan::made(const char* type, uint64_t handle) {
    const std::lock_guard lock(mutex_);
    live_.emplace(type, handle);
}

bool FailingVulkan::destroyed(const char* type, uint64_t handle) {
    if (handle == 0) return true;
    const std::lock_guard lock(mutex_);
    if (live_.erase({type, handle})) return true;
    mistakes_.push_back(std::string("an object of type ") + type + " is destroyed that is not there");
    return false;
}

void FailingVulkan::watchThread() {
    const std::lock_guard lock(mutex_);
    watched_ = std::this_thread::get_id();
    watchedCalls_.clear();
}

std::vector<std::string> FailingVulkan::watchedCalls() {
    const std::lock_guard lock(mutex_);
    watched_ = {};
    return std::exchange(watchedCalls_, {});
}

size_t FailingVulkan::liveMemory() const {
    size_t count = 0;
    for (const auto& [type, handle] : live_) count += type == typeid(VkDeviceMemory).name();
    return count;
}

std::string FailingVulkan::liveTypes() const {
    std::map<std::string, int> counts;
    for (const auto& [type, handle] : live_) ++counts[type];
    std::string text;
    for (const auto& [type, count] : counts) text += type + " x " + std::to_string(count) + ", ";
    return text;
}

}  // namespace dpl::test
