// SPDX-License-Identifier: Apache-2.0
// bench_writes AVATAR.glb [FRAMES = 60] [--json FILE]
//
// What it costs to write posed splats into a program's buffer, on the CPU (dplWriteSplats) and on its GPU (dplVulkanWriteSplats), in the
// layouts that engines ask for. Beside each: pose and projection of the same frame, as pictures need them. The GPU's numbers are compared
// with the CPU's. Ends with 1 if they differ by more than a picture of 8 bits shows, and without a Vulkan device after the rows of the CPU.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>

#include "apps/bench/json_row.h"
#include "apps/bench/thread_time.h"
#include "sdk/core/percentile.h"
#include "sdk/include/doppel/doppel_splats.h"
#include "sdk/include/doppel/doppel_vulkan.h"
#include "sdk/math/half.h"
#include "sdk/math/types.h"
#include "tests/unit/interop/app_device.h"
#include "tests/unit/interop/bench_cases.h"
#include "tools/bench/arguments.h"

namespace dpl::test {
namespace {

constexpr uint32_t kWarm = 2 * DPL_VULKAN_SLOTS;  // frames before the timed ones
constexpr float kEye[3] = {0, 1, 3};              // that of viewsOf()
constexpr double kMostPositionMm = 0.05, kMostColour = 1.0 / 255, kMostOpacity = 1.0 / 255;

struct Place {
    uint32_t property, numbers;
    DplNumber number = DPL_NUMBER_FLOAT;
    uint32_t bytes() const { return number == DPL_NUMBER_HALF ? (2 * numbers + 3) / 4 * 4 : 4 * numbers; }
};

/** Interleaved rows. */
struct Rows {
    std::string name;
    std::vector<Place> places;
    uint32_t shDegree = 0;

    uint32_t stride() const {
        uint32_t bytes = 0;
        for (const Place& place : places) bytes += place.bytes();
        return bytes;
    }
    std::vector<DplBufferElement> elements() const {
        std::vector<DplBufferElement> out;
        uint32_t offset = 0;
        for (const Place& place : places) {
            out.push_back({sizeof(DplBufferElement), place.property, place.number, 0, offset, stride()});
            offset += place.bytes();
        }
        return out;
    }
    /** The numbers of a property of a splat; false: the layout has none. */
    bool read(const uint8_t* bytes, size_t splat, uint32_t property, float* out) const {
        const uint8_t* at = bytes + splat * stride();
        for (const Place& place : places) {
            if (place.property == property) {
                for (uint32_t k = 0; k < place.numbers; ++k) {
                    uint16_t half = 0;
                    if (place.number == DPL_NUMBER_FLOAT)
                        std::memcpy(out + k, at + 4 * k, 4);
                    else
                        std::memcpy(&half, at + 2 * k, 2), out[k] = floatFromHalf(half);
                }
                return true;
            }
            at += place.bytes();
        }
        return false;
    }
};

std::vector<Rows> layoutsOf(uint32_t shDegree) {
    constexpr DplNumber kHalf = DPL_NUMBER_HALF;
    const Place position{DPL_SPLAT_POSITION, 3}, rotation{DPL_SPLAT_ROTATION, 4}, scale{DPL_SPLAT_SCALE, 3}, opacity{DPL_SPLAT_OPACITY, 1},
        colour{DPL_SPLAT_COLOUR, 3};
    return {{"one colour", {position, rotation, scale, opacity, colour}},
            {"covariance, one colour", {position, {DPL_SPLAT_COVARIANCE, 6}, opacity, colour}},
            {"one colour, halves",
             {position,
              {DPL_SPLAT_ROTATION, 4, kHalf},
              {DPL_SPLAT_SCALE, 3, kHalf},
              {DPL_SPLAT_OPACITY, 1, kHalf},
              {DPL_SPLAT_COLOUR, 3, kHalf}}},
            {"SH of degree " + std::to_string(shDegree),
             {position, rotation, scale, opacity, {DPL_SPLAT_SH, 3 * (shDegree + 1) * (shDegree + 1)}},
             shDegree}};
}

DplSplatOptions optionsOf(const Rows& rows) {
    return {sizeof(DplSplatOptions), 0, kEye, rows.shDegree};
}

/** Largest differences of the splats that show. */
struct Differences {
    double positionMm = 0, covariance = 0, opacity = 0, colour = 0;  // covariance: of the splat's largest variance
    bool seen() const { return positionMm > kMostPositionMm || colour > kMostColour || opacity > kMostOpacity; }
};

std::array<double, 6> covarianceOf(const Rows& rows, const uint8_t* bytes, size_t splat) {
    float six[6], q[4] = {}, s[3] = {};
    if (rows.read(bytes, splat, DPL_SPLAT_COVARIANCE, six)) return {six[0], six[1], six[2], six[3], six[4], six[5]};
    rows.read(bytes, splat, DPL_SPLAT_ROTATION, q), rows.read(bytes, splat, DPL_SPLAT_SCALE, s);
    Mat3d axes = glm::mat3_cast(glm::normalize(glm::dquat(q[3], q[0], q[1], q[2])));
    for (int k = 0; k < 3; ++k) axes[k] *= double(s[k]);
    const Mat3d c = axes * glm::transpose(axes);
    return {c[0][0], c[1][0], c[2][0], c[1][1], c[2][1], c[2][2]};
}

Differences compare(const Rows& rows, const std::vector<uint8_t>& want, const std::vector<uint8_t>& got) {
    Differences d;
    for (size_t i = 0; i < want.size() / rows.stride(); ++i) {
        float a[48] = {}, b[48] = {};
        const auto largest = [&](uint32_t property, uint32_t numbers) {
            double most = 0;
            if (!rows.read(want.data(), i, property, a) || !rows.read(got.data(), i, property, b)) return most;
            for (uint32_t k = 0; k < numbers; ++k) most = std::max(most, double(std::abs(a[k] - b[k])));
            return most;
        };
        d.opacity = std::max(d.opacity, largest(DPL_SPLAT_OPACITY, 1));
        if (!(a[0] > 0)) continue;
        d.positionMm = std::max(d.positionMm, 1000 * largest(DPL_SPLAT_POSITION, 3));
        d.colour = std::max({d.colour, largest(DPL_SPLAT_COLOUR, 3), largest(DPL_SPLAT_SH, 3 * (rows.shDegree + 1) * (rows.shDegree + 1))});
        const auto one = covarianceOf(rows, want.data(), i), other = covarianceOf(rows, got.data(), i);
        for (size_t k = 0; k < 6; ++k)
            d.covariance = std::max(d.covariance, std::abs(one[k] - other[k]) / std::max({one[0], one[3], one[5], 1e-12}));
    }
    return d;
}

/** An avatar in a context that draws on the CPU, by one thread. */
class OnCpu {
public:
    explicit OnCpu(const std::vector<uint8_t>& file) {
        const DplContextInfo info{sizeof info, DPL_RENDERER_SOFTWARE, 1};
        must(dplCreateContext(&info, &context_));
        must(dplLoadAvatar(context_, file.data(), file.size(), &avatar_));
        DplAvatarInfo about{sizeof about};
        must(dplGetAvatarInfo(avatar_, &about));
        splats = about.splatCount, shDegree = about.shDegree;
        screen_.resize(splats);
    }
    ~OnCpu() { (void)dplDestroyAvatar(avatar_), (void)dplDestroyContext(context_); }
    OnCpu(const OnCpu&) = delete;
    OnCpu& operator=(const OnCpu&) = delete;

    const std::vector<uint8_t>& write(const Rows& rows, uint32_t frame, double& ms) {
        bytes_.resize(size_t(splats) * rows.stride());
        const auto elements = rows.elements();
        const DplBuffer buffer{sizeof buffer, uint32_t(elements.size()), elements.data(), bytes_.data(), bytes_.size()};
        const DplSplatOptions options = optionsOf(rows);
        DplWritten written{sizeof written};
        pose(avatar_, frame);
        const double start = threadMs();
        must(dplWriteSplats(avatar_, &options, &buffer, &written));
        ms = threadMs() - start;
        return bytes_;
    }
    double project(uint32_t frame) {
        DplProjection made{sizeof made};
        const std::vector<DplCamera> views = viewsOf(kCases[0]);
        pose(avatar_, frame);
        const double start = threadMs();
        must(dplProject(context_, &avatar_, 1, views.data(), 1, screen_.data(), splats, &made));
        return threadMs() - start;
    }

    uint32_t splats = 0, shDegree = 0;

private:
    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    std::vector<uint8_t> bytes_;
    std::vector<DplScreenSplat> screen_;
};

/** An avatar in a program's own device, and a buffer in that device's memory. */
class OnGpu {
public:
    OnGpu(AppDevice& app, const std::vector<uint8_t>& file, uint64_t bytes) : app_(app) {
        DplVulkanDevice device{};
        device.structSize = sizeof device, device.queueFamily = app.family;
        device.instance = app.instance, device.physicalDevice = app.physical, device.device = app.device, device.queue = app.queue;
        device.enabledFeatures = &app.enabled;
        must(dplCreateVulkanContext(&device, nullptr, &context_));
        must(dplLoadAvatar(context_, file.data(), file.size(), &avatar_));
        rows_ = app.makeLocalBuffer(bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
        copy_ = app.makeBuffer(bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
        clock_ = app.clockTickNs();
        VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
        info.queryType = VK_QUERY_TYPE_TIMESTAMP, info.queryCount = 2 * DPL_VULKAN_SLOTS;
        if (clock_ > 0) MUST(vkCreateQueryPool(app.device, &info, nullptr, &times_));
    }
    ~OnGpu() {
        app_.waitAll();
        vkDestroyQueryPool(app_.device, times_, nullptr);
        app_.destroy(rows_), app_.destroy(copy_);
        (void)dplDestroyAvatar(avatar_), (void)dplDestroyContext(context_);
    }
    OnGpu(const OnGpu&) = delete;
    OnGpu& operator=(const OnGpu&) = delete;

    struct Cost {
        std::vector<double> threadMs, gpuMs;  // gpuMs: empty without timestamps
    };
    /** Three frames are in flight. */
    Cost timed(const Rows& rows, uint32_t frames) {
        Cost cost;
        bool waiting[DPL_VULKAN_SLOTS] = {};
        for (uint32_t n = 0; n < kWarm + frames + DPL_VULKAN_SLOTS; ++n) {
            const uint32_t slot = n % DPL_VULKAN_SLOTS;
            const VkCommandBuffer commands = app_.begin(slot);  // waits for the slot's last frame
            if (waiting[slot] && n >= kWarm + DPL_VULKAN_SLOTS && clock_ > 0) cost.gpuMs.push_back(between(slot));
            waiting[slot] = n < kWarm + frames;
            if (!waiting[slot]) {
                app_.submit(slot);
                continue;
            }
            const double spent = record(rows, n, slot, commands);
            if (n >= kWarm) cost.threadMs.push_back(spent);
            app_.submit(slot);
        }
        app_.waitAll();
        return cost;
    }
    std::vector<uint8_t> written(const Rows& rows, uint32_t frame, size_t bytes) {
        const VkCommandBuffer commands = app_.begin(0);
        (void)record(rows, frame, 0, commands);
        const VkBufferCopy all{0, 0, bytes};
        vkCmdCopyBuffer(commands, rows_.buffer, copy_.buffer, 1, &all);
        VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        memory.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT, memory.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
        app_.submit(0);
        app_.waitAll();
        return {copy_.mapped, copy_.mapped + bytes};
    }
    const char* name() const {
        const char* name = "";
        must(dplGetRendererName(context_, &name));
        return name;
    }

private:
    /** Thread time of the write. */
    double record(const Rows& rows, uint32_t frame, uint32_t slot, VkCommandBuffer commands) {
        pose(avatar_, frame);
        const auto elements = rows.elements();
        const DplVulkanBuffer buffer{sizeof buffer, uint32_t(elements.size()), elements.data(), rows_.buffer, rows_.bytes};
        const DplSplatOptions options = optionsOf(rows);
        DplWritten written{sizeof written};
        must(dplVulkanUpload(context_, commands, slot));
        if (times_ != VK_NULL_HANDLE) {
            vkCmdResetQueryPool(commands, times_, 2 * slot, 2);
            vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, times_, 2 * slot);
        }
        const double start = threadMs();
        must(dplVulkanWriteSplats(avatar_, commands, slot, &options, &buffer, &written));
        const double spent = threadMs() - start;
        if (times_ != VK_NULL_HANDLE) vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, times_, 2 * slot + 1);
        return spent;
    }
    double between(uint32_t slot) const {
        uint64_t ticks[2] = {};
        MUST(vkGetQueryPoolResults(app_.device, times_, 2 * slot, 2, sizeof ticks, ticks, 8, VK_QUERY_RESULT_64_BIT));
        return double(ticks[1] - ticks[0]) * clock_ * 1e-6;
    }

    AppDevice& app_;
    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    AppBuffer rows_, copy_;
    VkQueryPool times_ = VK_NULL_HANDLE;
    double clock_ = 0;  // ns a tick; 0: the queue has none
};

/** GPU time of a frame's passes that pose, cull and project; medians. Null without timestamps. */
std::optional<double> projectedByGpuMs(const std::vector<uint8_t>& file, uint32_t frames) {
    DplContext context = nullptr;
    const DplContextInfo info{sizeof info, DPL_RENDERER_VULKAN};
    if (dplCreateContext(&info, &context) != DPL_OK) return {};
    DplAvatar avatar = nullptr;
    must(dplLoadAvatar(context, file.data(), file.size(), &avatar));
    const std::vector<DplCamera> views = viewsOf(kCases[0]);
    std::vector<uint8_t> pixels(size_t(4) * views[0].widthPx * views[0].heightPx);
    const DplImage image{sizeof image, 0, pixels.data(), pixels.size()};
    std::vector<double> ms;
    for (uint32_t n = 0; n < kWarm + frames; ++n) {
        pose(avatar, n);
        must(dplRender(context, avatar, views.data(), 1, &image));
        DplFrameStats stats{sizeof stats};
        must(dplGetFrameStats(avatar, &stats));
        double sum = 0;
        for (uint32_t p = 0; p < stats.passCount; ++p) {
            DplPassTime pass{sizeof pass};
            must(dplGetPassTime(avatar, p, &pass));
            const std::string_view label = pass.label;
            if (label.starts_with("pose.") || label.starts_with("chunks.") || label.starts_with("splat.")) sum += pass.milliseconds;
        }
        if (n >= kWarm && sum > 0) ms.push_back(sum);
    }
    (void)dplDestroyAvatar(avatar), (void)dplDestroyContext(context);
    return ms.empty() ? std::nullopt : std::optional(percentile(ms, 0.5));
}

/** One row, printed and as JSON. besideMs: pose and projection, by the same clock as `ms`. */
std::string rowOf(const Rows& rows, const char* by, const char* device, uint32_t splats, double threadMs, double ms, double besideMs,
                  const std::optional<Differences>& d) {
    const double none = NAN, bytes = double(splats) * rows.stride();
    std::printf("%-24s %-22s %9.3f %9.3f %9.3f %6.2f %11.0f", rows.name.c_str(), by, threadMs, ms, besideMs, ms / besideMs, bytes);
    if (d)
        std::printf(" %9.2g %9.2g %9.2g %9.2g\n", d->positionMm, d->covariance, d->opacity, d->colour);
    else
        std::printf("\n");
    return JsonRow()
        .add("layout", rows.name)
        .add("by", by)
        .add("device", device)
        .add("splats", splats)
        .add("bytes", bytes)
        .add("thread_ms", threadMs)
        .add("ms", ms)
        .add("project_ms", besideMs)
        .add("ratio", ms / besideMs)
        .add("position_mm", d ? d->positionMm : none)
        .add("covariance", d ? d->covariance : none)
        .add("opacity", d ? d->opacity : none)
        .add("colour", d ? d->colour : none)
        .line();
}

int run(int argc, char** argv) {
    const BenchArguments arguments(argc, argv);
    if (arguments.count() < 1) return std::fprintf(stderr, "usage: bench_writes AVATAR.glb [FRAMES] [--json FILE]\n"), 2;
    const auto frames = uint32_t(std::clamp(arguments.number(1, 60), 3.0, 1e6));
    const auto file = readFile(arguments.text(0));
    if (!file) return std::fprintf(stderr, "bench_writes: %s\n", file.error().message.c_str()), 1;
    OnCpu cpu(*file);
    const std::vector<Rows> layouts = layoutsOf(cpu.shDegree);

    std::printf("%u splats, %u frames\n%-24s %-22s %9s %9s %9s %6s %11s %9s %9s %9s %9s\n", cpu.splats, frames, "layout", "by", "thread ms",
                "ms", "project", "ratio", "bytes", "pos mm", "cov", "opacity", "colour");
    std::string json;
    for (const Rows& rows : layouts) {
        std::vector<double> writing, projecting;
        for (uint32_t n = 0; n < kWarm + frames; ++n) {  // in turns, so that other work slows both
            double ms = 0;
            const double beside = cpu.project(2 * n);
            (void)cpu.write(rows, 2 * n + 1, ms);
            if (n >= kWarm) writing.push_back(ms), projecting.push_back(beside);
        }
        const double ms = percentile(writing, 0.5);
        json += rowOf(rows, "dplWriteSplats", "CPU, one thread", cpu.splats, ms, ms, percentile(projecting, 0.5), {});
    }

    std::string why;
    bool seen = false;
    if (const auto app = AppDevice::open({.validation = false}, why)) {
        uint64_t most = 0;
        for (const Rows& rows : layouts) most = std::max(most, uint64_t(cpu.splats) * rows.stride());
        OnGpu gpu(*app, *file, most);
        const std::optional<double> project = projectedByGpuMs(*file, frames);
        for (const Rows& rows : layouts) {
            const OnGpu::Cost cost = gpu.timed(rows, frames);
            double ignored = 0;
            const std::vector<uint8_t>& want = cpu.write(rows, kWarm + frames, ignored);
            const Differences d = compare(rows, want, gpu.written(rows, kWarm + frames, want.size()));
            json += rowOf(rows, "dplVulkanWriteSplats", gpu.name(), cpu.splats, percentile(cost.threadMs, 0.5),
                          cost.gpuMs.empty() ? NAN : percentile(cost.gpuMs, 0.5), project.value_or(NAN), d);
            seen = seen || d.seen();
        }
    } else {
        std::printf("dplVulkanWriteSplats was left out: %s\n", why.c_str());
    }
    std::printf(
        "thread ms: CPU time of the calling thread. ms: of the CPU the same, of a GPU by its clock. project: pose and projection of a\n"
        "picture of the same frame, by the same clock: dplProject, which also sorts; of a GPU the passes pose, chunks and splat.\n");
    if (auto written = arguments.writeJson(json); !written)
        return std::fprintf(stderr, "bench_writes: %s\n", written.error().message.c_str()), 1;
    if (seen) return std::fprintf(stderr, "bench_writes: the GPU's splats differ visibly from the CPU's\n"), 1;
    return 0;
}

}  // namespace
}  // namespace dpl::test

int main(int argc, char** argv) {
    return dpl::test::run(argc, argv);
}
