// SPDX-License-Identifier: Apache-2.0
// A Vulkan program with a lit room, as its author would write it: two people walk behind and in front of columns and a pane of glass,
// inside the program's own frames. The glass is drawn last, and who stands before it hides it by the depth that Doppel wrote. It draws a
// few frames, changes its size on the way, and compares the last frame of each size with what the CPU draws and composes.
//
//   vulkan_app AVATAR.glb [OUT.ppm]      exit 77: no Vulkan device
#include <doppel/doppel_convert.h>
#include <doppel/doppel_vulkan.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "room.h"

namespace {

constexpr uint32_t kFramesPerSize = 7;
constexpr double kLeastPsnrDb = 50;

void check(DplResult result) {
    if (result != DPL_OK) throw std::runtime_error(dplGetLastError());
}

/** From 1.5 m above the floor, looking slightly down, 50 degrees high. */
DplCamera cameraOf(VkExtent2D size) {
    const float eye[3] = {0, 1.5f, 4.2f}, target[3] = {0, 1, 0}, up[3] = {0, 1, 0};
    DplCamera camera{};
    camera.structSize = sizeof camera;
    check(dplCameraLookAt(eye, target, up, 0.874f, size.width, size.height, &camera));
    return camera;
}

/** Two people who walk past each other. */
class Walkers {
public:
    Walkers(DplContext context, const char* file) {
        for (DplAvatar& avatar : avatars) check(dplLoadAvatarFile(context, file, &avatar));
        DplAvatarInfo info{};
        info.structSize = sizeof info;
        check(dplGetAvatarInfo(avatars[0], &info));
        joints_ = info.jointCount, clips_ = info.clipCount;
        rotations_.resize(size_t(joints_) * 4);
    }
    ~Walkers() {
        for (DplAvatar avatar : avatars) dplDestroyAvatar(avatar);
    }
    Walkers(const Walkers&) = delete;
    Walkers& operator=(const Walkers&) = delete;

    void pose(double time) {
        for (int i = 0; i < 2; ++i) {
            if (clips_ > 0) check(dplSetPoseFromClip(avatars[i], 0, time + 0.3 * i, DPL_TRUE));
            float root[3];
            check(dplGetPose(avatars[i], rotations_.data(), joints_, root));
            const float along = float(0.22 * time) - 1.1f;
            root[0] += i == 0 ? along : -along - 0.1f;
            root[2] += i == 0 ? 0.95f : -0.35f;  // before all columns; between the front ones and the back one
            check(dplSetPose(avatars[i], rotations_.data(), joints_, root));
        }
    }

    DplAvatar avatars[2]{};

private:
    uint32_t joints_ = 0, clips_ = 0;
    std::vector<float> rotations_;
};

float floatOf(uint16_t half) {
    const int exponent = half >> 10 & 31;
    const float mantissa = float(half & 1023);
    const float value = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    return half & 0x8000 ? -value : value;
}

/** Of a number from 2^-14 to 65504, or 0 below. */
uint16_t halfOf(float value) {
    int exponent = 0;
    const float mantissa = std::frexp(value, &exponent);  // 0.5 to 1
    return value < 0x1p-14f ? uint16_t(0) : uint16_t((exponent + 13) * 1024 + int(std::lround(mantissa * 2048)));
}

class App {
public:
    explicit App(const char* file) : room_(device_) {
        DplVulkanDevice mine{};
        mine.structSize = sizeof mine;
        mine.queueFamily = device_.family;
        mine.instance = device_.instance, mine.physicalDevice = device_.physical, mine.device = device_.device, mine.queue = device_.queue;
        mine.enabledFeatures = &device_.enabled;
        check(dplCreateVulkanContext(&mine, nullptr, &context_));
        DplVulkanPass pass{};
        pass.structSize = sizeof pass;
        pass.renderPass = room_.composingPass();
        pass.colourFormat = kColourFormat;
        pass.samples = kSamples;
        pass.writesDepth = DPL_DRAW_DEPTH;
        check(dplCreateVulkanComposer(context_, &pass, &composer_));
        walkers_ = std::make_unique<Walkers>(context_, file);

        const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE, 0, 0, DPL_FILL_AUTO, nullptr};
        check(dplCreateContext(&software, &referee_));
        refereed_ = std::make_unique<Walkers>(referee_, file);

        VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        pool.queueFamilyIndex = device_.family;
        CHECK(vkCreateCommandPool(device_.device, &pool, nullptr, &pool_));
        VkCommandBufferAllocateInfo buffers{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        buffers.commandPool = pool_;
        buffers.commandBufferCount = DPL_VULKAN_SLOTS;
        CHECK(vkAllocateCommandBuffers(device_.device, &buffers, commands_));
        VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
        for (VkFence& f : fences_) CHECK(vkCreateFence(device_.device, &fence, nullptr, &f));
    }
    ~App() {
        vkDeviceWaitIdle(device_.device);
        walkers_.reset(), refereed_.reset();
        dplDestroyContext(context_);
        dplDestroyContext(referee_);
        for (Target& target : targets_) room_.destroy(target);
        for (VkFence fence : fences_) vkDestroyFence(device_.device, fence, nullptr);
        vkDestroyCommandPool(device_.device, pool_, nullptr);
    }

    /** Draws frames of one size and returns the PSNR of the last one against the CPU's. */
    double play(VkExtent2D size, const char* out) {
        targets_.push_back(room_.makeTarget(size));  // the old target stays: frames that use it may still run
        const Target& target = targets_.back();
        const DplCamera camera = cameraOf(size);
        for (uint32_t n = 0; n < kFramesPerSize; ++n) {
            walkers_->pose(time_ += 0.55);
            frame(target, camera, true, true);
        }
        const std::vector<uint16_t> drawn = read(target);
        frame(target, camera, false, true);
        const std::vector<uint16_t> roomWithGlass = read(target);
        frame(target, camera, false, false);
        const std::vector<uint16_t> expected = composedByTheCpu(camera, read(target), roomWithGlass);
        if (out) write(out, size, drawn);
        return psnrDb(drawn, expected);
    }

    /** Pixels of the last picture in which somebody stands before the glass. */
    int hidden() const { return hidden_; }
    const std::string& deviceName() const { return device_.name; }
    const std::vector<std::string>& complaints() const { return device_.complaints; }

private:
    void frame(const Target& target, const DplCamera& camera, bool withPeople, bool withGlass) {
        const uint32_t slot = uint32_t(frameNumber_++ % DPL_VULKAN_SLOTS);
        const VkCommandBuffer commands = commands_[slot];
        CHECK(vkWaitForFences(device_.device, 1, &fences_[slot], VK_TRUE, UINT64_MAX));
        CHECK(vkResetFences(device_.device, 1, &fences_[slot]));
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
        CHECK(vkBeginCommandBuffer(commands, &begin));
        room_.draw(commands, target, camera);
        if (withPeople) {
            DplVulkanSceneDepth depth{};
            depth.structSize = sizeof depth;
            depth.image = target.depth.view;
            depth.layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
            depth.samples = kSamples;
            depth.scale = 0, depth.offset = kNearM;  // reversed, infinite far plane
            check(dplVulkanPrepare(context_, commands, slot, walkers_->avatars, 2, &camera, 1, &depth));
        }
        room_.beginComposing(commands, target);
        if (withPeople) {
            check(dplVulkanCompose(context_, composer_, commands, slot, 0, 0, 0));
            check(dplVulkanComposeDepth(context_, composer_, commands, slot, 0, 0, 0, 0, kNearM));
        }
        if (withGlass) room_.drawGlass(commands, target, camera);
        room_.endComposing(commands);
        CHECK(vkEndCommandBuffer(commands));
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &commands;
        CHECK(vkQueueSubmit(device_.queue, 1, &submit, fences_[slot]));
    }

    /** Half floats of the resolved picture. Only this check reads pixels back. */
    std::vector<uint16_t> read(const Target& target) {
        CHECK(vkDeviceWaitIdle(device_.device));
        std::vector<uint16_t> halves(size_t(target.size.width) * target.size.height * 4);
        VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        info.size = halves.size() * 2;
        info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        VkBuffer buffer = VK_NULL_HANDLE;
        CHECK(vkCreateBuffer(device_.device, &info, nullptr, &buffer));
        VkMemoryRequirements needs{};
        vkGetBufferMemoryRequirements(device_.device, buffer, &needs);
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocation.allocationSize = needs.size;
        allocation.memoryTypeIndex =
            device_.memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
        VkDeviceMemory memory = VK_NULL_HANDLE;
        CHECK(vkAllocateMemory(device_.device, &allocation, nullptr, &memory));
        CHECK(vkBindBufferMemory(device_.device, buffer, memory, 0));
        const VkCommandBuffer commands = commands_[0];
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        CHECK(vkBeginCommandBuffer(commands, &begin));
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {target.size.width, target.size.height, 1};
        vkCmdCopyImageToBuffer(commands, target.resolved.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
        VkMemoryBarrier host{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        host.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        host.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0, nullptr, 0, nullptr);
        CHECK(vkEndCommandBuffer(commands));
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &commands;
        CHECK(vkQueueSubmit(device_.queue, 1, &submit, VK_NULL_HANDLE));
        CHECK(vkDeviceWaitIdle(device_.device));
        void* mapped = nullptr;
        CHECK(vkMapMemory(device_.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped));
        std::memcpy(halves.data(), mapped, halves.size() * 2);
        vkDestroyBuffer(device_.device, buffer, nullptr);
        vkFreeMemory(device_.device, memory, nullptr);
        return halves;
    }

    /** The people over the room, and then the glass. Where nobody is, it is roomWithGlass. */
    std::vector<uint16_t> composedByTheCpu(DplCamera camera, std::vector<uint16_t> room, const std::vector<uint16_t>& roomWithGlass) {
        std::vector<float> depth(size_t(camera.widthPx) * camera.heightPx);
        for (uint32_t y = 0; y < camera.heightPx; ++y)
            for (uint32_t x = 0; x < camera.widthPx; ++x) depth[size_t(y) * camera.widthPx + x] = roomDepthM(camera, x, y);
        camera.sceneDepthM = depth.data(), camera.sceneDepthCount = depth.size();
        DplImage image{};
        image.structSize = sizeof image;
        image.flags = DPL_IMAGE_OVER;
        image.format = DPL_FORMAT_RGBA16F;
        image.rgba = reinterpret_cast<uint8_t*>(room.data()), image.rgbaBytes = room.size() * 2;
        refereed_->pose(time_);
        check(dplRenderTogether(referee_, refereed_->avatars, 2, &camera, 1, &image));
        std::vector<uint8_t> people(depth.size() * 4);
        std::vector<float> peopleM(depth.size());
        image.flags = 0, image.format = DPL_FORMAT_RGBA8;
        image.rgba = people.data(), image.rgbaBytes = people.size();
        image.depthM = peopleM.data(), image.depthCount = peopleM.size();
        check(dplRenderTogether(referee_, refereed_->avatars, 2, &camera, 1, &image));
        hidden_ = 0;
        for (size_t i = 0; i < peopleM.size(); ++i) {
            const auto x = uint32_t(i % camera.widthPx), y = uint32_t(i / camera.widthPx);
            const bool writesDepth = float(people[4 * i + 3]) / 255 >= DPL_VULKAN_DEPTH_COVERAGE;
            const int shown = glassSamples(camera, x, y, writesDepth ? peopleM[i] : 0);
            if (writesDepth && shown < glassSamples(camera, x, y, 0)) ++hidden_;
            for (size_t c = 0; c < 4; ++c) {
                uint16_t& half = room[4 * i + c];
                half = people[4 * i + 3] == 0 ? roomWithGlass[4 * i + c]
                                              : halfOf(floatOf(half) * (1 - float(shown) / 4 * kGlass[3]) + float(shown) / 4 * kGlass[c]);
            }
        }
        return room;
    }

    static double psnrDb(const std::vector<uint16_t>& a, const std::vector<uint16_t>& b) {
        double sum = 0;
        for (size_t i = 0; i < a.size(); ++i) {
            const double d = std::min(1.0f, floatOf(a[i])) - std::min(1.0f, floatOf(b[i]));
            sum += d * d;
        }
        return 10 * std::log10(double(a.size()) / std::max(sum, 1e-12));
    }

    static void write(const char* path, VkExtent2D size, const std::vector<uint16_t>& halves) {
        std::ofstream out(path, std::ios::binary);
        out << "P6\n" << size.width << ' ' << size.height << "\n255\n";
        for (size_t i = 0; i < halves.size(); i += 4)
            for (size_t c = 0; c < 3; ++c) {
                const double linear = std::min(1.0f, floatOf(halves[i + c]));
                const double display = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
                out.put(char(uint8_t(std::lround(255 * display))));
            }
    }

    Device device_;
    Room room_;
    DplContext context_ = nullptr, referee_ = nullptr;
    uint32_t composer_ = 0;
    std::unique_ptr<Walkers> walkers_, refereed_;
    std::vector<Target> targets_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_[DPL_VULKAN_SLOTS]{};
    VkFence fences_[DPL_VULKAN_SLOTS]{};
    uint64_t frameNumber_ = 0;
    double time_ = 0;
    int hidden_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::printf("usage: vulkan_app AVATAR.glb [OUT.ppm]\n"), 2;
    try {
        App app(argv[1]);
        bool good = true;
        for (const VkExtent2D size : {VkExtent2D{400, 500}, VkExtent2D{640, 400}}) {
            const double db = app.play(size, size.width == 640 && argc > 2 ? argv[2] : nullptr);
            std::printf("%u x %u on %s: %.1f dB to the CPU's composition, %d pixels of people before the glass\n", size.width, size.height,
                        app.deviceName().c_str(), db, app.hidden());
            good &= db >= kLeastPsnrDb && app.hidden() > 500;
        }
        for (const std::string& complaint : app.complaints()) std::fprintf(stderr, "%s\n", complaint.c_str());
        return good && app.complaints().empty() ? 0 : 1;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "vulkan_app: %s\n", e.what());
        return std::string(e.what()) == "no Vulkan device" ? 77 : 1;
    }
}
