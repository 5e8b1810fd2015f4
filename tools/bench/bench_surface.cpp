// SPDX-License-Identifier: Apache-2.0
// bench_surface AVATAR [FRAMES]
//
// Times the calls about the posed surface on the CPU, in the poses of the avatar's first clip: medians and 95th percentiles. "first call":
// it poses the vertices; then the shadow and rays of the same pose. Rays go from a ring of 3 m around the avatar to places within its box;
// the first one after a pose fits the boxes of triangles. At last it says of each layer whether it can be hidden.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "sdk/include/doppel/doppel.hpp"
#include "tools/bench/arguments.h"

namespace {

int failed(const std::string& why) {
    return std::fprintf(stderr, "bench_surface: %s\n", why.c_str()), 1;
}

double millisecondsOf(const auto& what) {
    const auto begin = std::chrono::steady_clock::now();
    what();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void print(const char* name, std::vector<double> ms) {
    std::sort(ms.begin(), ms.end());
    std::printf("%-28s %8.3f ms, p95 %8.3f ms\n", name, ms[ms.size() / 2], ms[ms.size() * 95 / 100]);
}

}  // namespace

int main(int argc, char** argv) {
    const dpl::BenchArguments arguments(argc, argv);
    if (arguments.count() < 1) return failed("usage: bench_surface AVATAR [FRAMES]");
    const auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    if (!context) return failed(context.error().message);
    auto avatar = context->loadAvatarFile(arguments.text(0));
    if (!avatar) return failed(avatar.error().message);
    const auto info = avatar->info();
    if (!info) return failed(info.error().message);
    if (info->jointCount == 0) return failed(arguments.text(0) + " holds general splats, which have no surface");
    const int frames = std::max(2, int(arguments.number(1, 200)));
    std::vector<double> posing, shadows, firstRays, rays;
    std::mt19937 random(1);
    uint32_t met = 0;
    for (int f = 0; f < frames; ++f) {
        if (info->clipCount > 0)
            (void)avatar->setPoseFromClip(0, 0.0371 * f);
        else if (auto rest = std::vector<float>(size_t(info->jointCount) * 4, 0); true) {
            for (size_t w = 3; w < rest.size(); w += 4) rest[w] = 1;
            (void)avatar->setPose(rest, std::array<float, 3>{0.001f * float(f), 0, 0});
        }
        posing.push_back(millisecondsOf([&] { (void)avatar->contactShadow(); }));
        shadows.push_back(millisecondsOf([&] { (void)avatar->contactShadow(); }));
        for (int r = 0; r < 20; ++r) {
            std::uniform_real_distribution<float> share(0, 1);
            std::array<float, 3> to{}, along{};
            for (size_t k = 0; k < 3; ++k) to[k] = info->restMin[k] + share(random) * (info->restMax[k] - info->restMin[k]);
            const float turn = 6.2832f * share(random);
            const std::array<float, 3> from{3 * std::cos(turn), 2 * share(random), 3 * std::sin(turn)};
            for (size_t k = 0; k < 3; ++k) along[k] = to[k] - from[k];
            (r == 0 ? firstRays : rays).push_back(millisecondsOf([&] {
                const auto pick = doppel::pick({*avatar}, from, along);
                met += pick && pick->hit ? 1 : 0;
            }));
        }
    }
    std::printf("%s: %u vertices, %u triangles, %d poses\n", info->name, info->vertexCount, info->triangleCount, frames);
    for (size_t i = 0; i < posing.size(); ++i) posing[i] -= shadows[i];
    print("posing, in the first call", posing);
    print("contact shadow", shadows);
    firstRays.erase(firstRays.begin());  // it makes the clusters
    print("first ray of a pose", firstRays);
    print("further rays", rays);
    std::printf("%u of %zu rays met the avatar\n", met, rays.size() + firstRays.size() + 1);
    for (uint32_t l = 0; l < info->layerCount; ++l) {
        const auto layer = avatar->layer(l);
        const doppel::Status hidden = avatar->hideLayer(l);
        if (layer) std::printf("%s: %s\n", layer->name, hidden ? "can be hidden" : hidden.error().message.c_str());
        if (hidden) (void)avatar->hideLayer(l, false);
    }
    return 0;
}
