// SPDX-License-Identifier: Apache-2.0
// bench_vulkan FILE [width height eyeY eyeZ frames [quads|tiles|metal-quads|metal-tiles [picture.ppm]]]
//
// Draws one file of general splats through the public API on Vulkan (a software device is allowed) or Metal with the camera of bench_splat.
// Prints the median times of the device's passes in bench_splat's format, so that floor_compare.sh can compare the two.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "sdk/core/files.h"
#include "sdk/include/doppel/doppel.hpp"

namespace {

double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + ptrdiff_t(v.size() / 2), v.end());
    return v[v.size() / 2];
}

int failed(const std::string& why) {
    return std::fprintf(stderr, "bench_vulkan: %s\n", why.c_str()), 1;
}

}  // namespace

int main(int argc, char** argv) {
    const auto argument = [&](int i, double fallback) { return argc > i ? std::atof(argv[i]) : fallback; };
    if (argc < 2)
        return std::fprintf(stderr,
                            "usage: bench_vulkan FILE [width height eyeY eyeZ frames [quads|tiles|metal-quads|metal-tiles [picture.ppm]]]; "
                            "FILE holds general splats\n"),
               2;
    const auto bytes = dpl::readFile(argv[1]);
    if (!bytes) return failed(bytes.error().message);
    const std::string how = argc > 7 ? argv[7] : "tiles";
    const bool tiles = how.ends_with("tiles"), metal = how.starts_with("metal-");
    auto context = doppel::Context::create(metal ? DPL_RENDERER_METAL : DPL_RENDERER_VULKAN, 0, 0, tiles ? DPL_FILL_TILES : DPL_FILL_QUADS);
    if (!context) return failed(context.error().message);
    auto splats = context->loadAvatar(*bytes);
    if (!splats) return failed(splats.error().message);

    DplCamera camera{};
    camera.structSize = sizeof camera;
    camera.widthPx = uint32_t(argument(2, 2048)), camera.heightPx = uint32_t(argument(3, 945));
    camera.fx = camera.fy = float(camera.widthPx / (2 * std::tan(3.14159265358979 / 8)));
    camera.cx = float(camera.widthPx) / 2, camera.cy = float(camera.heightPx) / 2;
    const float view[12] = {1, 0, 0, 0, 0, -1, 0, float(argument(4, 0.9)), 0, 0, -1, float(argument(5, 4.85))};
    std::copy_n(view, 12, camera.viewFromWorld);
    std::vector<uint8_t> rgba(size_t(camera.widthPx) * camera.heightPx * 4);
    DplImage image{};
    image.structSize = sizeof image, image.rgba = rgba.data(), image.rgbaBytes = rgba.size();

    const uint32_t frames = std::max(1u, uint32_t(argument(6, 9)));
    std::vector<double> times[5];
    uint32_t drawn = 0, entries = 0;
    bool overflowed = false;
    for (uint32_t frame = 0; frame < frames + 3; ++frame) {
        if (auto status = splats->render({&camera, 1}, {&image, 1}); !status) return failed(status.error().message);
        auto stats = splats->frameStats();
        if (!stats) return failed(stats.error().message);
        if (frame < 3) continue;  // warm-up
        double parts[5] = {};
        for (uint32_t i = 0; i < stats->passCount; ++i) {
            const auto pass = splats->passTime(i);
            if (!pass) return failed(pass.error().message);
            const std::string label = pass->label;
            const bool raster = label == "tiles.fill" || label == "tiles.search" || label == "draw.splats" || label == "readback";
            const int part = label.starts_with("splat.")                                   ? 0
                             : label.starts_with("sort.") || label.starts_with("compact.") ? 1
                             : raster                                                      ? 3
                                                                                           : 2;
            parts[part] += pass->milliseconds, parts[4] += pass->milliseconds;
        }
        for (int k = 0; k < 5; ++k) times[k].push_back(parts[k]);
        drawn = stats->splatsDrawn, entries = stats->tileEntries, overflowed = stats->tilesOverflowed;
    }
    std::printf("%s %s %ux%u splats=%u entries=%u%s | project+SH %.2f sort %.2f bin %.2f raster %.2f total-median %.2f min %.2f ms\n",
                context->rendererName().c_str(), argv[1], camera.widthPx, camera.heightPx, drawn, entries,
                overflowed ? " (overflowed: quads)" : "", median(times[0]), median(times[1]), median(times[2]), median(times[3]),
                median(times[4]), *std::min_element(times[4].begin(), times[4].end()));
    if (argc > 8) {
        std::FILE* file = std::fopen(argv[8], "wb");
        if (!file) return failed(std::string("cannot write ") + argv[8]);
        std::fprintf(file, "P6 %u %u 255\n", camera.widthPx, camera.heightPx);
        for (size_t i = 0; i < rgba.size(); i += 4) std::fwrite(&rgba[i], 1, 3, file);
        std::fclose(file);
    }
    return 0;
}
