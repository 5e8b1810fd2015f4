// SPDX-License-Identifier: Apache-2.0
// bench_load_frames [SPLATS = 500000] [vulkan | software] [--json FILE]
//
// The longest frame while a file of general splats loads: without a load, with a load in the background (dplStartLoad), and with
// dplLoadAvatar on another thread. A frame is dplDraw of a small avatar, 90 times a second; its time is what the call takes of the calling
// thread, in CPU time and by the clock. The program makes the file itself.
#include <doppel/doppel.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <random>
#include <string>
#include <thread>

#include "apps/bench/json_row.h"
#include "apps/bench/thread_time.h"
#include "sdk/core/percentile.h"
#include "sdk/format/ply.h"
#include "tools/bench/arguments.h"

namespace {

using Clock = std::chrono::steady_clock;
using Ms = std::chrono::duration<double, std::milli>;

constexpr auto kInterval = std::chrono::microseconds(1'000'000 / 90);
constexpr size_t kFewestFrames = 300;

int failed(const std::string& why) {
    return std::fprintf(stderr, "bench_load_frames: %s\n", why.c_str()), 1;
}

/** A ball of splats of SH degree 3, one metre above the origin. */
std::vector<uint8_t> ball(uint32_t count) {
    dpl::StaticSplatData s;
    s.shDegree = 3;
    std::mt19937 random(1);
    const auto unit = [&] { return float(double(random()) * 0x1p-31 - 1); };
    for (uint32_t i = 0; i < count; ++i) {
        s.position.push_back({0.5f * unit(), 1 + 0.5f * unit(), 0.5f * unit()});
        s.rotation.push_back(glm::normalize(dpl::Quatf(1.1f + unit(), unit(), unit(), unit())));
        s.scaleM.push_back(dpl::Vec3f(0.006f + 0.004f * unit()));
        s.opacity.push_back(0.5f + 0.4f * unit());
        for (int k = 0; k < 48; ++k) s.sh.push_back((k < 3 ? 1.5f : 0.2f) * unit());
    }
    auto bytes = dpl::writePly(s);
    return bytes ? std::move(*bytes) : std::vector<uint8_t>();
}

struct Frames {
    std::vector<double> wallMs, cpuMs;
    double loadMs = 0;
};

/** Draws until `done` says so, which is asked once a frame, and at least kFewestFrames times if there is no load. */
template <class Done>
doppel::Status drawUntil(const doppel::Avatar& shown, const DplCamera& camera, Frames& frames, Done&& done) {
    for (auto next = Clock::now(); !done(frames.wallMs.size()); next += kInterval) {
        std::this_thread::sleep_until(next);
        const double cpu = dpl::threadMs();
        const auto start = Clock::now();
        if (auto drawn = shown.draw({&camera, 1}); !drawn) return drawn;
        frames.wallMs.push_back(Ms(Clock::now() - start).count());
        frames.cpuMs.push_back(dpl::threadMs() - cpu);
        next = std::max(next, Clock::now() - kInterval);
    }
    return {};
}

}  // namespace

int main(int argc, char** argv) {
    const dpl::BenchArguments arguments(argc, argv);
    const auto splats = uint32_t(arguments.number(0, 500000));
    const std::string renderer = arguments.text(1, "vulkan");
    if (splats == 0 || splats > (16u << 20) || (renderer != "vulkan" && renderer != "software"))
        return std::fprintf(stderr, "usage: bench_load_frames [SPLATS] [vulkan | software] [--json FILE]; 1 to 16777216 splats\n"), 2;
    const std::vector<uint8_t> big = ball(splats), small = ball(5000);
    auto context = doppel::Context::create(renderer == "vulkan" ? DPL_RENDERER_VULKAN : DPL_RENDERER_SOFTWARE, 1, 0, DPL_FILL_QUADS);
    if (!context) return failed(context.error().message);
    auto shown = context->loadAvatar(small);
    if (!shown) return failed(shown.error().message);
    const DplCamera camera{sizeof camera, 128, 128, 120, 120, 64, 64, {1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3}, nullptr, 0};
    Frames warm;
    if (auto drawn = drawUntil(*shown, camera, warm, [](size_t n) { return n == 10; }); !drawn) return failed(drawn.error().message);

    std::string json;
    for (const char* way : {"no load", "dplStartLoad", "dplLoadAvatar on another thread"}) {
        Frames frames;
        std::string problem;
        const auto start = Clock::now();
        doppel::Status drawn;
        if (way == std::string("no load")) {
            drawn = drawUntil(*shown, camera, frames, [](size_t n) { return n >= kFewestFrames; });
        } else if (way == std::string("dplStartLoad")) {
            auto load = context->startLoad(big);
            if (!load) return failed(load.error().message);
            drawn = drawUntil(*shown, camera, frames, [&](size_t) {
                const auto status = load->status();
                return !status || status->state >= DPL_LOAD_READY;
            });
            frames.loadMs = Ms(Clock::now() - start).count();
            if (auto avatar = load->finish(); !avatar) problem = avatar.error().message;
        } else {
            std::atomic<bool> ended{false};
            std::thread thread([&] {
                if (auto avatar = context->loadAvatar(big); !avatar) problem = avatar.error().message;
                ended = true;
            });
            drawn = drawUntil(*shown, camera, frames, [&](size_t) { return ended.load(); });
            frames.loadMs = Ms(Clock::now() - start).count();
            thread.join();
        }
        if (!drawn) return failed(drawn.error().message);
        if (!problem.empty()) return failed(problem);
        const double longestMs = *std::max_element(frames.wallMs.begin(), frames.wallMs.end());
        const double longestCpuMs = *std::max_element(frames.cpuMs.begin(), frames.cpuMs.end());
        const double p50 = dpl::percentile(frames.wallMs, 0.5), p95 = dpl::percentile(frames.wallMs, 0.95);
        const double cpuP50 = dpl::percentile(frames.cpuMs, 0.5);
        std::printf("%-32s longest frame %8.2f ms (CPU %6.2f)  median %6.2f (CPU %5.2f)  p95 %6.2f  %4zu frames  load %7.0f ms\n", way,
                    longestMs, longestCpuMs, p50, cpuP50, p95, frames.wallMs.size(), frames.loadMs);
        dpl::JsonRow row;
        row.add("row", dpl::formatText("longest frame while {} splats load", splats)).add("way", way);
        row.add("device", context->rendererName()).add("splats", splats).add("frames", frames.wallMs.size());
        row.add("longest_ms", longestMs).add("longest_cpu_ms", longestCpuMs).add("frame_ms_p50", p50).add("frame_ms_p95", p95);
        row.add("cpu_ms_p50", cpuP50).add("load_ms", frames.loadMs);
        json += row.line();
    }
    const dpl::Status written = arguments.writeJson(json);
    return written ? 0 : failed(written.error().message);
}
