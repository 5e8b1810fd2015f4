// SPDX-License-Identifier: Apache-2.0
// Stands between Doppel and Vulkan: lets a chosen call fail, loses the device, and counts the objects that are made and destroyed.
//
//   DplVulkanDevice::getInstanceProcAddr = failingVulkan().entry()
//
// Every function of the device that Doppel calls goes through it, by the list of sdk/backend/vulkan/vk_functions.h. Calls that the test's
// own program makes do not. A failed call writes a bad handle, because Vulkan says that it is undefined.
#pragma once

#include <vulkan/vulkan_core.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace dpl::test {

/** One device at a time. Doppel may call from several threads; what a getter refers to is read while Doppel does nothing. */
class FailingVulkan {
public:
    PFN_vkGetInstanceProcAddr entry();

    /** The call-th call from now, counted from 1, that can fail returns `error`; 0: none. function: only calls of this one count.
     *  VK_ERROR_DEVICE_LOST: the device has run what was submitted, and from then on every submission, wait and query fails, until mend().
     */
    void failAt(uint64_t call, VkResult error, const std::string& function = {});
    void mend() { failAt(0, VK_SUCCESS), lost_ = false; }

    /** Notes the calls of this thread alone that can fail, until they are taken. */
    void watchThread();
    std::vector<std::string> watchedCalls();

    const std::vector<std::string>& calls() const { return calls_; }        // that can fail, since failAt(): the functions' names
    const std::string& failed() const { return failed_; }                   // the function that failed since failAt(); empty: none yet
    std::set<std::string> everCalled, everFailed;                           // functions
    bool recording() const { return recording_; }                           // Doppel is in a vkCmd function
    size_t live() const { return live_.size(); }                            // objects
    size_t liveMemory() const;                                              // of them, those of vkAllocateMemory
    std::string liveTypes() const;                                          // for messages
    const std::vector<std::string>& mistakes() const { return mistakes_; }  // objects destroyed that were not there

    // For the functions in the table.
    void record(bool recording) { recording_ = recording; }
    VkResult before(const char* function);
    void made(const char* type, uint64_t handle);
    bool destroyed(const char* type, uint64_t handle);
    PFN_vkVoidFunction wrapped(VkDevice device, const char* name);

private:
    std::vector<std::string> calls_;
    std::string only_;
    uint64_t failAt_ = 0;
    VkResult error_ = VK_SUCCESS;
    bool lost_ = false;
    std::atomic<bool> recording_ = false;
    std::thread::id watched_;
    std::vector<std::string> watchedCalls_;
    std::mutex mutex_;
    std::string failed_;
    VkDevice device_ = VK_NULL_HANDLE;
    std::set<std::pair<std::string, uint64_t>> live_;  // type and handle
    std::vector<std::string> mistakes_;
};

FailingVulkan& failingVulkan();

}  // namespace dpl::test
