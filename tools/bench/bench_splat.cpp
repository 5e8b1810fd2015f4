// SPDX-License-Identifier: Apache-2.0
// bench_splat FILE [width height eyeY eyeZ threads frames [picture.ppm]]
//
// Draws one file of general splats with the software renderer from (0, eyeY, eyeZ) along −z with a 45° horizontal field of view (the camera
// of research/proto-splat/floor.cpp) and prints the median time of each step, so that floor_compare.sh can compare the two.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "sdk/core/files.h"
#include "sdk/format/splat_file.h"
#include "sdk/splat/splat_engine.h"

namespace {

using namespace dpl;

bool load(const char* path, StaticSplatData& out) {
    const auto bytes = readFile(path);
    auto file = bytes ? readSplats(*bytes) : Result<SplatFile>(bytes.error());
    if (!file) return std::fprintf(stderr, "%s\n", file.error().message.c_str()), false;
    out = std::move(file->splats);
    return out.count() > 0;
}

double nowMs() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + ptrdiff_t(v.size() / 2), v.end());
    return v[v.size() / 2];
}

void writePpm(const char* path, const Cameraf& camera, const std::vector<uint8_t>& rgba) {
    std::FILE* file = std::fopen(path, "wb");
    if (!file) return;
    std::fprintf(file, "P6 %u %u 255\n", camera.widthPx, camera.heightPx);
    for (size_t i = 0; i < rgba.size(); i += 4) std::fwrite(rgba.data() + i, 1, 3, file);
    std::fclose(file);
}

}  // namespace

int main(int argc, char** argv) {
    const auto argument = [&](int i, double fallback) { return argc > i ? std::atof(argv[i]) : fallback; };
    StaticSplatData splats;
    if (argc < 2 || !load(argv[1], splats)) {
        std::fprintf(stderr, "usage: bench_splat FILE [width height eyeY eyeZ threads frames [picture.ppm]]; FILE holds general splats\n");
        return 2;
    }
    Cameraf camera;
    camera.widthPx = uint32_t(argument(2, 2048)), camera.heightPx = uint32_t(argument(3, 945));
    camera.fx = camera.fy = float(camera.widthPx / (2 * std::tan(3.14159265358979 / 8)));
    camera.cx = float(camera.widthPx) / 2, camera.cy = float(camera.heightPx) / 2;
    camera.viewFromWorldRotation = Mat3f(1, 0, 0, 0, -1, 0, 0, 0, -1);
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * Vec3f(0, float(argument(4, 0.9)), float(argument(5, 4.85))));
    const uint32_t threads = uint32_t(argument(6, 2)), frames = std::max(1u, uint32_t(argument(7, 15)));

    Jobs jobs(threads);
    const PackedSplats packed(splats);
    SplatEngine engine(jobs);
    std::vector<uint8_t> rgba;
    std::vector<double> times[5];
    for (uint32_t frame = 0; frame < frames + 3; ++frame) {
        const double t0 = nowMs();
        engine.project(packed, {}, camera, splats.kappaPx2, splats.compensated);
        const double t1 = nowMs();
        engine.sort();
        const double t2 = nowMs();
        engine.bin();
        const double t3 = nowMs();
        engine.blendRgba8(rgba);
        const double t4 = nowMs();
        if (frame < 3) continue;  // warm-up
        times[0].push_back(t1 - t0), times[1].push_back(t2 - t1), times[2].push_back(t3 - t2), times[3].push_back(t4 - t3);
        times[4].push_back(t4 - t0);
    }
    std::printf(
        "doppel %s %ux%u threads=%u splats=%u inst=%u | project+SH %.2f sort %.2f bin %.2f raster %.2f total-median %.2f min %.2f ms\n",
        argv[1], camera.widthPx, camera.heightPx, threads, splats.count(), engine.tiles().offset.back(), median(times[0]), median(times[1]),
        median(times[2]), median(times[3]), median(times[4]), *std::min_element(times[4].begin(), times[4].end()));
    if (argc > 8) writePpm(argv[8], camera, rgba);
    return 0;
}
