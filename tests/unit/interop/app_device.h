// SPDX-License-Identifier: Apache-2.0
// A Vulkan program of its own for tests: instance with validation, device, command buffers, images and passes. It links libvulkan, as a
// stranger's program does, and uses nothing of sdk/backend.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace dpl::test {

/** Ends the program with a sentence unless the call succeeded. */
void must(VkResult result, const char* call);
#define MUST(call) dpl::test::must(call, #call)

struct AppImage {
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;    // 2D array of all layers
    std::vector<VkImageView> layerViews;  // 2D, one a layer
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkImageAspectFlags aspects = 0;
    uint32_t width = 0, height = 0, layers = 1, samples = 1;
};

struct AppBuffer {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint8_t* mapped = nullptr;
    VkDeviceSize bytes = 0;
};

/** Any failing call ends the program with its name: a test bench has no other answer. One thread. */
class AppDevice {
public:
    struct Options {
        bool multiview = true;
        bool dynamicRendering = false;
        bool validation = true;
        bool timeline = false;  // semaphores
    };
    /** Null with the reason when there is no Vulkan device. */
    static std::unique_ptr<AppDevice> open(const Options& options, std::string& why);
    ~AppDevice();

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;
    VkPhysicalDeviceFeatures2 enabled{};  // with the chain that was enabled
    bool validated = false;               // the validation layer is installed
    std::vector<std::string> messages;    // of the validation layer

    /** A target: colour attachment, copied to and from, sampled. It begins in TRANSFER_SRC_OPTIMAL. */
    AppImage makeTarget(VkFormat format, uint32_t width, uint32_t height, uint32_t layers = 1, uint32_t samples = 1);
    /** A depth attachment, sampled too. It begins in DEPTH_STENCIL_ATTACHMENT_OPTIMAL. Views show depth alone. */
    AppImage makeDepthTarget(VkFormat format, uint32_t width, uint32_t height, uint32_t layers = 1, uint32_t samples = 1);
    bool isDepthTarget(VkFormat format) const;  // whether the device has such images
    /** A depth image (D32 or D16) that holds `values`, one list a layer, rows without padding. It is in DEPTH_STENCIL_READ_ONLY_OPTIMAL. */
    AppImage makeDepth(VkFormat format, uint32_t width, uint32_t height, std::span<const std::vector<float>> values);
    /** The same with four samples a pixel, all of one value. */
    AppImage makeFourSampleDepth(uint32_t width, uint32_t height, float value);
    void destroy(AppImage& image);
    /** Mapped, coherent. */
    AppBuffer makeBuffer(VkDeviceSize bytes, VkBufferUsageFlags usage);
    /** In the memory of the device, not mapped. */
    AppBuffer makeLocalBuffer(VkDeviceSize bytes, VkBufferUsageFlags usage);
    void destroy(AppBuffer& buffer);
    /** Nanoseconds of a tick of vkCmdWriteTimestamp; 0: the queue has none. */
    double clockTickNs() const;

    /** A pass with one colour attachment and, with a depth format, a depth attachment: LOAD and STORE, COLOR_ATTACHMENT_OPTIMAL and
     *  DEPTH_STENCIL_ATTACHMENT_OPTIMAL before and after. */
    VkRenderPass makePass(VkFormat format, uint32_t samples, uint32_t viewMask, VkFormat depthFormat = VK_FORMAT_UNDEFINED);
    VkFramebuffer makeFramebuffer(VkRenderPass pass, std::initializer_list<VkImageView> views, uint32_t width, uint32_t height);

    /** Fills a layer with bytes, rows without padding, and reads it back. 1 sample. Both wait. */
    void upload(const AppImage& image, uint32_t layer, std::span<const uint8_t> bytes);
    std::vector<uint8_t> download(const AppImage& image, uint32_t layer);

    /** Command buffers that are recorded again and again, each with a fence. */
    VkCommandBuffer begin(uint32_t slot);  // waits for the slot's last submission
    void submit(uint32_t slot, VkSemaphore wait = VK_NULL_HANDLE, VkSemaphore signal = VK_NULL_HANDLE);
    void waitAll();

    void barrier(VkCommandBuffer commands, const AppImage& image, VkImageLayout from, VkImageLayout to);
    static constexpr uint32_t kUploadSlot = 3;

private:
    AppDevice() = default;
    bool openInstance(const Options& options, std::string& why);
    bool openDevice(const Options& options, std::string& why);
    uint32_t memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const;
    AppBuffer makeBufferIn(VkMemoryPropertyFlags memory, VkDeviceSize bytes, VkBufferUsageFlags usage);
    void makeImage(AppImage& image, VkImageUsageFlags usage);
    /** A mapped buffer of `bytes` bytes that lives until the next call. */
    void staging(VkDeviceSize bytes);

    static constexpr uint32_t kSlots = kUploadSlot + 1;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDeviceMultiviewFeatures multiview_{};
    VkPhysicalDeviceDynamicRenderingFeatures dynamic_{};
    VkPhysicalDeviceTimelineSemaphoreFeatures timeline_{};
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_[kSlots]{};
    VkFence fences_[kSlots]{};
    AppBuffer staging_;
};

uint32_t bytesPerPixel(VkFormat format);

}  // namespace dpl::test
