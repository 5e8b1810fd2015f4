// SPDX-License-Identifier: Apache-2.0
// bench_host AVATAR.glb [FRAMES = 40] [SHRINK = 16] [--json FILE]
//
// What a frame costs on the CPU before the GPU gets it: Doppel's calls alone, on the thread that makes them, through Metal and through
// Vulkan. Each backend is timed twice. Once its commands go nowhere, so that only Doppel's own code is left. Once they go to what stands in
// for a driver here: to the software Metal device, which checks them and then runs none of them, and to lavapipe, which records them. No
// command runs while a call is timed. The Metal pictures are compared with the CPU renderer's in frames SHRINK times smaller, since the
// software device takes minutes for a large one. Ends with 1 if one is below 50 dB, or if the software device found a fault.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>

#include "apps/bench/count_allocations.h"
#include "apps/bench/json_row.h"
#include "apps/bench/thread_time.h"
#include "sdk/core/percentile.h"
#include "sdk/include/doppel/doppel_metal.h"
#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/metal/software/software_device.h"
#include "tests/reference/composition.h"
#include "tests/unit/interop/app_device.h"
#include "tests/unit/interop/bench_cases.h"
#include "tests/unit/interop/idle_vulkan.h"
#include "tools/bench/arguments.h"

namespace dpl::test {
namespace {

constexpr uint32_t kWarm = 3;  // frames before the timed ones, one for each slot
constexpr double kLeastDb = 50;
constexpr uint8_t kUnder[4] = {64, 128, 192, 255};  // what the program's image holds before
static_assert(DPL_METAL_SLOTS == DPL_VULKAN_SLOTS);

/** Of Doppel's calls in one frame. */
class Calls {
public:
    template <class Call>
    void time(Call&& call) {
        const auto start = std::chrono::steady_clock::now();
        const double before = threadMs();
        AllocationCount count(CountedThreads::Own);
        must(call());
        allocations += count.stop();
        cpuMs += threadMs() - before;
        wallMs += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    }
    double cpuMs = 0, wallMs = 0;
    uint64_t allocations = 0;
};

/** A program that draws an avatar into its image, in two ways. */
class Program {
public:
    virtual ~Program() = default;
    /** Prepares and composes in the program's commands. */
    virtual void inside(uint32_t slot, Calls& calls) = 0;
    /** Doppel commits. */
    virtual void submitted(uint32_t slot, Calls& calls) = 0;
    /** Nothing runs any more, and every slot is free. */
    virtual void finish() = 0;
    DplAvatar avatar() const { return avatar_; }

protected:
    void load(const std::vector<uint8_t>& file) { must(dplLoadAvatar(context_, file.data(), file.size(), &avatar_)); }
    void close() { must(dplDestroyAvatar(avatar_)), must(dplDestroyContext(context_)); }

    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    std::vector<DplCamera> views_;
    uint32_t composer_ = 0;
};
constexpr DplContextInfo kQuads = {sizeof(DplContextInfo), DPL_RENDERER_AUTO, 1, 0, DPL_FILL_QUADS, nullptr};

/** Stereo is layered: both eyes in one texture and one pass. */
class MetalProgram final : public Program {
public:
    MetalProgram(const std::vector<uint8_t>& file, const Case& what, mtl::SoftwareWork work)
        : device_({.work = work}), app_(device_.seam()), layers_(what.views == 2 ? 2 : 0) {
        views_ = viewsOf(what);
        const DplMetalDevice mine{sizeof mine, 0, device_.device(), device_.queue()};
        must(dplCreateMetalContext(&mine, &kQuads, &context_));
        load(file);
        const DplMetalPass pass{sizeof pass, uint32_t(mtl::PixelFormat::RGBA8Unorm), 0, 0, 1, layers_, 0};
        must(dplCreateMetalComposer(context_, &pass, &composer_));
        mtl::TextureDesc desc;
        desc.type = layers_ ? mtl::TextureType::Array : mtl::TextureType::Flat;
        desc.widthPx = what.width, desc.heightPx = what.height, desc.layers = what.views;
        desc.usage = mtl::kUsageRenderTarget | mtl::kUsageShaderRead, desc.tracked = true;
        image_ = app_->newTexture(desc, "of the program");
    }
    ~MetalProgram() override {
        finish();
        close();
        app_->release(image_);
    }
    void inside(uint32_t slot, Calls& calls) override {
        const mtl::CommandsRef commands = app_->commandBuffer();
        calls.time(
            [&] { return dplMetalPrepare(context_, commands.object, slot, &avatar_, 1, views_.data(), uint32_t(views_.size()), nullptr); });
        mtl::RenderEncoderRef encoder = app_->renderEncoder(commands, clearing());
        calls.time([&] { return dplMetalCompose(context_, composer_, encoder.object, slot, 0, 0, 0); });
        app_->end(encoder);
        app_->release(encoder);
        commit(commands);
    }
    void submitted(uint32_t slot, Calls& calls) override {
        const mtl::CommandsRef commands = app_->commandBuffer();
        mtl::RenderEncoderRef encoder = app_->renderEncoder(commands, clearing());
        app_->end(encoder);
        app_->release(encoder);
        commit(commands);
        finish();  // else the software device clears the image within the call
        DplMetalSubmission how{};
        how.structSize = sizeof how, how.textureCount = 1, how.textures[0] = image_.object;
        calls.time(
            [&] { return dplMetalSubmit(context_, composer_, slot, &avatar_, 1, views_.data(), uint32_t(views_.size()), nullptr, &how); });
    }
    void finish() override { device_.finish(); }
    std::vector<std::string> faults() { return device_.takeFaults(); }

    /** The smallest PSNR of the image's layers against the CPU renderer. */
    double psnr(DplContext cpu, DplAvatar same) {
        double least = INFINITY;
        for (uint32_t view = 0; view < views_.size(); ++view) {
            const size_t bytes = size_t(views_[view].widthPx) * views_[view].heightPx * 4;
            std::vector<uint8_t> want(bytes);
            for (size_t i = 0; i < bytes; ++i) want[i] = kUnder[i % 4];
            DplImage image{sizeof image, DPL_IMAGE_OVER, want.data(), want.size()};
            must(dplRender(cpu, same, &views_[view], 1, &image));
            mtl::BufferRef copy = app_->newBuffer(bytes, mtl::StorageMode::Shared, "copy");
            const mtl::CommandsRef commands = app_->commandBuffer();
            mtl::BlitEncoderRef encoder = app_->blitEncoder(commands);
            app_->copyTexture(encoder, image_, view, views_[view].widthPx, views_[view].heightPx, copy, 0, views_[view].widthPx * 4);
            app_->end(encoder);
            app_->release(encoder);
            commit(commands);
            finish();
            const auto* data = reinterpret_cast<const uint8_t*>(app_->contents(copy));
            least = std::min(least, reference::psnrDb(reference::TargetFormat::Rgba8, std::vector<uint8_t>(data, data + bytes), want));
            app_->release(copy);
        }
        return least;
    }

private:
    mtl::RenderPassDesc clearing() const {
        mtl::RenderPassDesc desc;
        desc.colours[0].texture = image_;
        for (int c = 0; c < 4; ++c) desc.colours[0].clear[c] = kUnder[c] / 255.0;
        desc.layers = layers_;
        return desc;
    }
    void commit(mtl::CommandsRef commands) {
        app_->commit(commands);
        app_->release(commands);
    }

    mtl::SoftwareDevice device_;
    std::unique_ptr<mtl::Seam> app_;
    mtl::TextureRef image_;
    const uint32_t layers_;
};

/** Stereo has a pass for each eye, as lavapipe needs. */
class VulkanProgram final : public Program {
public:
    VulkanProgram(const std::vector<uint8_t>& file, const Case& what, AppDevice& app, bool idle)
        : app_(app), idle_(idle), image_(app.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, what.width, what.height, what.views)) {
        views_ = viewsOf(what);
        DplVulkanDevice device{};
        device.structSize = sizeof device, device.queueFamily = app.family, device.getInstanceProcAddr = idleVulkan();
        device.instance = app.instance, device.physicalDevice = app.physical, device.device = app.device, device.queue = app.queue;
        device.enabledFeatures = &app.enabled;
        must(dplCreateVulkanContext(&device, &kQuads, &context_));
        load(file);
        pass_ = app.makePass(image_.format, 1, 0);
        DplVulkanPass info{};
        info.structSize = sizeof info, info.renderPass = pass_, info.colourFormat = image_.format;
        must(dplCreateVulkanComposer(context_, &info, &composer_));
        DplVulkanTarget target{};
        target.structSize = sizeof target, target.imageCount = what.views;
        for (uint32_t view = 0; view < what.views; ++view) {
            framebuffers_.push_back(app.makeFramebuffer(pass_, {image_.layerViews[view]}, what.width, what.height));
            target.images[view] = image_.layerViews[view];
        }
        target.format = image_.format, target.widthPx = what.width, target.heightPx = what.height;
        target.layoutBefore = target.layoutAfter = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        must(dplCreateVulkanTarget(context_, &target, &target_));
        setVulkanIdle(idle);
    }
    ~VulkanProgram() override {
        finish();
        setVulkanIdle(false);
        close();
        for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(app_.device, framebuffer, nullptr);
        vkDestroyRenderPass(app_.device, pass_, nullptr);
        app_.destroy(image_);
    }
    void inside(uint32_t slot, Calls& calls) override {
        const VkCommandBuffer commands = app_.begin(slot);
        calls.time(
            [&] { return dplVulkanPrepare(context_, commands, slot, &avatar_, 1, views_.data(), uint32_t(views_.size()), nullptr); });
        app_.barrier(commands, image_, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        for (uint32_t view = 0; view < views_.size(); ++view) {
            VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
            begin.renderPass = pass_, begin.framebuffer = framebuffers_[view];
            begin.renderArea.extent = {image_.width, image_.height};
            vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            calls.time([&] { return dplVulkanCompose(context_, composer_, commands, slot, view, 0, 0); });
            vkCmdEndRenderPass(commands);
        }
        app_.barrier(commands, image_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        app_.submit(slot);
    }
    void submitted(uint32_t slot, Calls& calls) override {
        DplVulkanSubmission how{};
        how.structSize = sizeof how;
        calls.time(
            [&] { return dplVulkanSubmit(context_, target_, slot, &avatar_, 1, views_.data(), uint32_t(views_.size()), nullptr, &how); });
    }
    void finish() override {
        app_.waitAll();
        (void)vkQueueWaitIdle(app_.queue);
        for (uint32_t slot = 0; idle_ && slot < DPL_VULKAN_SLOTS; ++slot) must(dplVulkanDropSlot(context_, slot));
    }

private:
    AppDevice& app_;
    const bool idle_;
    AppImage image_;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    std::vector<VkFramebuffer> framebuffers_;
    uint32_t target_ = 0;
};

struct Way {
    const char* name;
    void (Program::*run)(uint32_t slot, Calls& calls);
};
constexpr Way kWays[] = {{"prepare and compose", &Program::inside}, {"submit", &Program::submitted}};

struct Cost {
    double cpuMs, wallMs, allocations;
};
Cost costOf(Program& program, const Way& way, uint32_t frames) {
    std::vector<double> cpu, wall;
    uint64_t allocations = 0;
    for (uint32_t frame = 0; frame < kWarm + frames; ++frame) {
        pose(program.avatar(), frame);
        Calls calls;
        (program.*way.run)(frame % DPL_METAL_SLOTS, calls);
        program.finish();
        if (frame < kWarm) continue;
        cpu.push_back(calls.cpuMs), wall.push_back(calls.wallMs);
        allocations += calls.allocations;
    }
    return {percentile(cpu, 0.5), percentile(wall, 0.5), double(allocations) / frames};
}

struct Judge {
    DplContext cpu = nullptr;
    DplAvatar avatar = nullptr;
};
/** Of the picture that the commands give when they run. The second frame, since it meets what the first one left. */
double psnrOf(const std::vector<uint8_t>& file, Case what, const Way& way, uint32_t shrink, const Judge& judge, size_t& faults) {
    what.width = std::max(what.width / shrink, 1u), what.height = std::max(what.height / shrink, 1u);
    MetalProgram program(file, what, mtl::SoftwareWork::All);
    for (uint32_t frame = 0; frame < 2; ++frame) {
        pose(program.avatar(), frame), pose(judge.avatar, frame);
        Calls calls;
        (program.*way.run)(frame, calls);
        program.finish();
    }
    const double db = program.psnr(judge.cpu, judge.avatar);
    for (const std::string& fault : program.faults()) std::fprintf(stderr, "fault: %s\n", fault.c_str()), ++faults;
    return db;
}

int run(int argc, char** argv) {
    const BenchArguments arguments(argc, argv);
    if (arguments.count() < 1) return std::fprintf(stderr, "usage: bench_host AVATAR.glb [FRAMES] [SHRINK] [--json FILE]\n"), 2;
    const auto frames = uint32_t(std::clamp(arguments.number(1, 40), 3.0, 1e6)),
               shrink = uint32_t(std::clamp(arguments.number(2, 16), 1.0, 64.0));
    const auto file = readFile(arguments.text(0));
    if (!file) return std::fprintf(stderr, "bench_host: %s\n", file.error().message.c_str()), 1;
    Judge judge;
    const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE};
    must(dplCreateContext(&software, &judge.cpu));
    must(dplLoadAvatar(judge.cpu, file->data(), file->size(), &judge.avatar));
    std::string why;
    const auto app = AppDevice::open({.validation = false}, why);
    if (!app) std::fprintf(stderr, "Vulkan is left out: %s\n", why.c_str());

    size_t faults = 0;
    double least = INFINITY;
    std::string json;
    std::printf("%-26s %-20s %-34s %8s %8s %12s %9s\n", "case", "calls", "commands go to", "CPU ms", "wall ms", "allocations", "PSNR dB");
    for (const Case& what : kCases) {
        for (const Way& way : kWays) {
            const auto row = [&](const char* backend, const char* to, Program& program, double db) {
                const Cost cost = costOf(program, way, frames);
                std::printf("%-26s %-20s %-34s %8.4f %8.4f %12.1f %9.1f\n", what.name, way.name, to, cost.cpuMs, cost.wallMs,
                            cost.allocations, db);
                json += JsonRow()
                            .add("case", what.name)
                            .add("way", way.name)
                            .add("backend", backend)
                            .add("commands_to", to)
                            .add("thread_ms", cost.cpuMs)
                            .add("wall_ms", cost.wallMs)
                            .add("allocations", cost.allocations)
                            .add("psnr_db", db)
                            .line();
            };
            const double db = psnrOf(*file, what, way, shrink, judge, faults);
            least = std::min(least, db);
            {
                MetalProgram program(*file, what, mtl::SoftwareWork::Nothing);
                row("Metal", "nowhere", program, NAN);
            }
            {
                MetalProgram program(*file, what, mtl::SoftwareWork::NoShaders);
                row("Metal", "software device, not run", program, db);
                for (const std::string& fault : program.faults()) std::fprintf(stderr, "fault: %s\n", fault.c_str()), ++faults;
            }
            for (const bool idle : {true, false}) {
                if (!app) continue;
                VulkanProgram program(*file, what, *app, idle);
                row("Vulkan", idle ? "nowhere" : "lavapipe, recorded", program, NAN);
            }
        }
    }
    must(dplDestroyAvatar(judge.avatar)), must(dplDestroyContext(judge.cpu));
    if (auto written = arguments.writeJson(json); !written)
        return std::fprintf(stderr, "bench_host: %s\n", written.error().message.c_str()), 1;
    if (least < kLeastDb || std::isnan(least))
        return std::fprintf(stderr, "bench_host: a picture is %.1f dB from the CPU renderer's, below %.0f\n", least, kLeastDb), 1;
    return faults ? 1 : 0;
}

}  // namespace
}  // namespace dpl::test

int main(int argc, char** argv) {
    return dpl::test::run(argc, argv);
}
