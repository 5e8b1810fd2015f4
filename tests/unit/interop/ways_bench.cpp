// SPDX-License-Identifier: Apache-2.0
// bench_ways AVATAR.glb [FRAMES = 60] [SHRINK = 1] [--json FILE]
//
// The ways in which a Vulkan program gets an avatar into its image: by reading the picture back and uploading it again, or inside its own
// frame. Prints what each costs the calling thread, how long a frame takes, how many bytes of pixels cross the bus, and the difference to
// the CPU renderer. SHRINK divides the sides of the images. Ends with 1 if a picture is below 50 dB, with 77 without a Vulkan device.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>

#include "apps/bench/count_allocations.h"
#include "apps/bench/json_row.h"
#include "apps/bench/thread_time.h"
#include "sdk/core/percentile.h"
#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/reference/composition.h"
#include "tests/unit/interop/app_device.h"
#include "tests/unit/interop/bench_cases.h"
#include "tools/bench/arguments.h"

namespace dpl::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_SRGB;
constexpr uint32_t kWarm = 2 * DPL_VULKAN_SLOTS;  // frames before the timed ones
constexpr double kLeastDb = 50;

double wallMs() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<uint8_t> background(uint32_t width, uint32_t height) {
    std::vector<uint8_t> pixels(size_t(width) * height * 4);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            uint8_t* p = &pixels[(size_t(y) * width + x) * 4];
            p[0] = uint8_t(200 * x / width), p[1] = uint8_t(230 * y / height), p[2] = 80, p[3] = 255;
        }
    return pixels;
}

/** Draws `views` over what `pixels` hold, a picture each. */
void renderOver(DplContext context, DplAvatar avatar, const std::vector<DplCamera>& views, std::vector<std::vector<uint8_t>>& pixels) {
    std::vector<DplImage> images;
    for (auto& picture : pixels) {
        DplImage image{sizeof image, DPL_IMAGE_OVER, picture.data(), picture.size()};
        image.format = DPL_FORMAT_RGBA8_SRGB;
        images.push_back(image);
    }
    must(dplRender(context, avatar, views.data(), uint32_t(views.size()), images.data()));
}

struct Cost {
    std::vector<double> threadMs;
    double frameMs = 0;
    uint64_t allocations = 0;  // by the timed calls, in all frames
};

/** A program's target of one case. multiview: one pass for both layers, where the device can; else a pass for each. */
class Program {
public:
    Program(AppDevice& app, DplContext context, DplAvatar avatar, const Case& what, bool multiview)
        : app_(app),
          context_(context),
          avatar_(avatar),
          views_(viewsOf(what)),
          under_(background(what.width, what.height)),
          target_(app.makeTarget(kFormat, what.width, what.height, what.views)) {
        masked_ = multiview && what.views == 2 && addPass(3);
        if (!masked_) addPass(0);
    }
    ~Program() {
        waitForAll();
        (void)dplDestroyVulkanComposer(context_, composer_);
        if (submitTarget_ != 0) (void)dplDestroyVulkanTarget(context_, submitTarget_);
        for (VkFence fence : fences_) vkDestroyFence(app_.device, fence, nullptr);
        for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(app_.device, framebuffer, nullptr);
        for (VkRenderPass pass : passes_) vkDestroyRenderPass(app_.device, pass, nullptr);
        app_.destroy(target_);
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    bool masked() const { return masked_; }
    size_t pixelBytes() const { return under_.size() * views_.size(); }

    /** The picture comes to the CPU, which composes it, and goes back to the GPU. */
    Cost byReadingBack(uint32_t frames) {
        std::vector<std::vector<uint8_t>> pixels(views_.size());
        return timed(frames, [&](uint32_t, Cost& cost) {
            for (auto& picture : pixels) picture = under_;
            const double start = threadMs();
            AllocationCount count(CountedThreads::Own);
            renderOver(context_, avatar_, views_, pixels);
            cost.allocations += count.stop();
            for (uint32_t layer = 0; layer < pixels.size(); ++layer) app_.upload(target_, layer, pixels[layer]);
            cost.threadMs.push_back(threadMs() - start);
        });
    }
    /** Both views of a frame are prepared together. */
    Cost inside(uint32_t frames) {
        return timed(frames, [&](uint32_t n, Cost& cost) { draw(n % DPL_VULKAN_SLOTS, 0, uint32_t(views_.size()), cost, true); });
    }
    /** The same with a submission of Doppel's. */
    Cost submitted(uint32_t frames) {
        if (submitTarget_ == 0) makeSubmitTarget();
        return timed(frames, [&](uint32_t n, Cost& cost) {
            const uint32_t slot = n % DPL_VULKAN_SLOTS;
            (void)vkWaitForFences(app_.device, 1, &fences_[slot], VK_TRUE, UINT64_MAX);
            (void)vkResetFences(app_.device, 1, &fences_[slot]);
            fillForJudging();
            DplVulkanSubmission how{};
            how.structSize = sizeof how, how.fence = fences_[slot];
            const double start = threadMs();
            AllocationCount count(CountedThreads::Own);
            must(dplVulkanSubmit(context_, submitTarget_, slot, &avatar_, 1, views_.data(), uint32_t(views_.size()), nullptr, &how));
            cost.allocations += count.stop();
            cost.threadMs.push_back(threadMs() - start);
        });
    }
    /** Each view is a frame of its own. */
    Cost insideOneByOne(uint32_t frames) {
        return timed(frames, [&](uint32_t n, Cost& cost) {
            for (uint32_t view = 0; view < views_.size(); ++view)
                draw((n * uint32_t(views_.size()) + view) % DPL_VULKAN_SLOTS, view, 1, cost, view == 0);
        });
    }
    /** The smallest PSNR of the last frame's layers against the CPU renderer. */
    double psnr(DplContext cpu, DplAvatar same, uint32_t frames) {
        waitForAll();
        pose(same, kWarm + frames);
        std::vector<std::vector<uint8_t>> expected(views_.size(), under_);
        renderOver(cpu, same, views_, expected);
        double least = INFINITY;
        for (uint32_t layer = 0; layer < expected.size(); ++layer)
            least = std::min(least, reference::psnrDb(reference::TargetFormat::Rgba8Srgb, app_.download(target_, layer), expected[layer]));
        return least;
    }

private:
    bool addPass(uint32_t viewMask) {
        const VkRenderPass pass = app_.makePass(kFormat, 1, viewMask);
        passes_.push_back(pass);
        DplVulkanPass info{};
        info.structSize = sizeof info, info.renderPass = pass, info.viewMask = viewMask, info.colourFormat = kFormat;
        const DplResult made = dplCreateVulkanComposer(context_, &info, &composer_);
        if (viewMask && made == DPL_ERROR_UNSUPPORTED) return false;
        must(made);
        for (uint32_t layer = 0; layer < (viewMask ? 1 : target_.layers); ++layer)
            framebuffers_.push_back(
                app_.makeFramebuffer(pass, {viewMask ? target_.view : target_.layerViews[layer]}, target_.width, target_.height));
        return true;
    }

    void makeSubmitTarget() {
        for (VkFence& fence : fences_) {
            VkFenceCreateInfo info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
            info.flags = VK_FENCE_CREATE_SIGNALED_BIT;
            (void)vkCreateFence(app_.device, &info, nullptr, &fence);
        }
        DplVulkanTarget info{};
        info.structSize = sizeof info;
        info.imageCount = masked_ ? 1 : uint32_t(views_.size()), info.viewMask = masked_ ? 3 : 0;
        for (uint32_t i = 0; i < info.imageCount; ++i) info.images[i] = masked_ ? target_.view : target_.layerViews[i];
        info.format = kFormat, info.widthPx = target_.width, info.heightPx = target_.height;
        info.layoutBefore = info.layoutAfter = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        must(dplCreateVulkanTarget(context_, &info, &submitTarget_));
    }
    void waitForAll() {
        app_.waitAll();
        (void)vkQueueWaitIdle(app_.queue);
    }
    void fillForJudging() {
        if (!last_) return;
        waitForAll();
        for (uint32_t layer = 0; layer < target_.layers; ++layer) app_.upload(target_, layer, under_);
    }

    Cost timed(uint32_t frames, const std::function<void(uint32_t, Cost&)>& frame) {
        Cost cost;
        double start = 0;
        last_ = false;
        for (uint32_t n = 0; n < kWarm + frames; ++n) {
            if (n == kWarm) waitForAll(), cost = {}, start = wallMs();
            pose(avatar_, n);
            frame(n, cost);
        }
        waitForAll();
        cost.frameMs = (wallMs() - start) / frames;
        last_ = true;
        Cost judged;
        pose(avatar_, kWarm + frames);
        frame(kWarm + frames, judged);
        return cost;
    }

    /** Prepares `count` views from `first` on and composes each into its layer. fresh: the target is filled with the background first. */
    void draw(uint32_t slot, uint32_t first, uint32_t count, Cost& cost, bool fresh) {
        if (fresh) fillForJudging();
        const VkCommandBuffer commands = app_.begin(slot);
        double start = threadMs();
        AllocationCount preparing(CountedThreads::Own);
        must(dplVulkanPrepare(context_, commands, slot, &avatar_, 1, &views_[first], count, nullptr));
        cost.allocations += preparing.stop();
        double spent = threadMs() - start;
        app_.barrier(commands, target_, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        for (uint32_t view = 0; view < (masked_ ? 1 : count); ++view) {
            VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
            begin.renderPass = passes_.back(), begin.framebuffer = framebuffers_[masked_ ? 0 : first + view];
            begin.renderArea.extent = {target_.width, target_.height};
            vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            start = threadMs();
            AllocationCount composing(CountedThreads::Own);
            must(dplVulkanCompose(context_, composer_, commands, slot, view, 0, 0));  // with a view mask, every view
            cost.allocations += composing.stop();
            spent += threadMs() - start;
            vkCmdEndRenderPass(commands);
        }
        app_.barrier(commands, target_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_.submit(slot);
        if (fresh)
            cost.threadMs.push_back(spent);
        else
            cost.threadMs.back() += spent;
    }

    AppDevice& app_;
    const DplContext context_;
    const DplAvatar avatar_;
    const std::vector<DplCamera> views_;
    const std::vector<uint8_t> under_;
    AppImage target_;
    std::vector<VkRenderPass> passes_;
    std::vector<VkFramebuffer> framebuffers_;
    uint32_t composer_ = 0, submitTarget_ = 0;
    VkFence fences_[DPL_VULKAN_SLOTS] = {};
    bool masked_ = false;
    bool last_ = false;  // the frame that is judged
};

struct Way {
    const char* name;
    Cost (Program::*run)(uint32_t frames);
    bool crossesTheBus, multiview;
    uint32_t leastViews;
};
constexpr Way kWays[] = {{"read back, composed by the CPU, uploaded", &Program::byReadingBack, true, false, 1},
                         {"inside the app's frame", &Program::inside, false, true, 1},
                         {"inside, submitted by Doppel", &Program::submitted, false, true, 1},
                         {"inside, a frame for each eye", &Program::insideOneByOne, false, false, 2}};

int run(int argc, char** argv) {
    const BenchArguments arguments(argc, argv);
    if (arguments.count() < 1) return std::fprintf(stderr, "usage: bench_ways AVATAR.glb [FRAMES] [SHRINK] [--json FILE]\n"), 2;
    const auto frames = uint32_t(std::clamp(arguments.number(1, 60), 3.0, 1e6)),
               shrink = uint32_t(std::clamp(arguments.number(2, 1), 1.0, 64.0));
    const auto file = readFile(arguments.text(0));
    if (!file) return std::fprintf(stderr, "bench_ways: %s\n", file.error().message.c_str()), 1;
    std::string why;
    const auto app = AppDevice::open({.validation = false}, why);
    if (!app) return std::fprintf(stderr, "skipped: %s\n", why.c_str()), 77;

    DplVulkanDevice device{};
    device.structSize = sizeof device, device.queueFamily = app->family;
    device.instance = app->instance, device.physicalDevice = app->physical, device.device = app->device, device.queue = app->queue;
    device.enabledFeatures = &app->enabled;
    DplContext gpu = nullptr, cpu = nullptr;
    must(dplCreateVulkanContext(&device, nullptr, &gpu));
    const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE};
    must(dplCreateContext(&software, &cpu));
    DplAvatar avatar = nullptr, same = nullptr;
    must(dplLoadAvatar(gpu, file->data(), file->size(), &avatar));
    must(dplLoadAvatar(cpu, file->data(), file->size(), &same));
    const char* name = "";
    must(dplGetRendererName(gpu, &name));

    std::string json;
    double least = INFINITY;
    std::printf("%s\n%-26s %-42s %10s %10s %14s %12s %9s\n", name, "case", "way", "thread ms", "frame ms", "pixel bytes", "allocations",
                "PSNR dB");
    for (Case what : kCases) {
        what.width /= shrink, what.height /= shrink;
        for (const Way& way : kWays) {
            if (what.views < way.leastViews) continue;
            Program program(*app, gpu, avatar, what, way.multiview);
            Cost cost = (program.*way.run)(frames);
            const double db = program.psnr(cpu, same, frames), ms = percentile(cost.threadMs, 0.5);
            const double bytes = way.crossesTheBus ? 2.0 * double(program.pixelBytes()) : 0,
                         allocations = double(cost.allocations) / frames;
            least = std::min(least, db);
            std::printf("%-26s %-42s %10.3f %10.2f %14.0f %12.1f %9.1f\n", what.name, way.name, ms, cost.frameMs, bytes, allocations, db);
            json += JsonRow()
                        .add("case", what.name)
                        .add("way", way.name)
                        .add("device", name)
                        .add("views", what.views)
                        .add("multiview", int(program.masked()))
                        .add("thread_ms", ms)
                        .add("frame_ms", cost.frameMs)
                        .add("pixel_bytes", bytes)
                        .add("allocations", allocations)
                        .add("psnr_db", db)
                        .line();
        }
    }
    must(dplDestroyAvatar(avatar)), must(dplDestroyAvatar(same));
    must(dplDestroyContext(gpu)), must(dplDestroyContext(cpu));
    if (auto written = arguments.writeJson(json); !written)
        return std::fprintf(stderr, "bench_ways: %s\n", written.error().message.c_str()), 1;
    if (least < kLeastDb)
        return std::fprintf(stderr, "bench_ways: a picture is %.1f dB from the CPU renderer's, below %.0f\n", least, kLeastDb), 1;
    return 0;
}

}  // namespace
}  // namespace dpl::test

int main(int argc, char** argv) {
    return dpl::test::run(argc, argv);
}
