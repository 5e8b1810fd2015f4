// SPDX-License-Identifier: Apache-2.0
// bench_load AVATAR.glb [SPLATS = 533695] [SH DEGREE = 1] [BIG.glb | -] [compact] [--json FILE]
//
// Measures the time and the peak memory of loading an avatar through the public SDK with the CPU renderer. The avatar's splats are first
// increased to SPLATS. BIG.glb: where to keep the enlarged avatar for other benches. compact: writes splat encoding 3.
#include <doppel/doppel.hpp>

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <random>
#include <string>

#include "apps/bench/json_row.h"
#include "reconstruction/output/package/sh_palette.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"
#include "tools/bench/arguments.h"

namespace {

std::atomic<int64_t> live = 0, peak = 0;  // heap bytes of all threads

void* counted(size_t size, size_t alignment) {
    void* p = alignment > 16 ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment) : std::malloc(size ? size : 1);
    if (!p) throw std::bad_alloc();
    const int64_t now = live += int64_t(malloc_usable_size(p));
    for (int64_t seen = peak; now > seen && !peak.compare_exchange_weak(seen, now);) {
    }
    return p;
}
void release(void* p) noexcept {
    if (p) live -= int64_t(malloc_usable_size(p));
    std::free(p);
}

/** The avatar with `count` splats: copies of its own, each moved a little, smaller and with another colour. */
dpl::AvatarData blownUp(const dpl::AvatarData& a, uint32_t count, uint32_t shDegree) {
    dpl::AvatarData out = a;
    const dpl::SplatData& s = a.splats;
    out.splats = {};
    out.splats.shDegree = shDegree;
    const size_t from = dpl::shCoefficientCount(s.shDegree) * 3, to = dpl::shCoefficientCount(shDegree) * 3;
    std::vector<uint32_t> triangle, triangleOfSplat(s.count());
    for (uint32_t t = 0; t + 1 < s.triangleStart.size(); ++t)
        std::fill(triangleOfSplat.begin() + s.triangleStart[t], triangleOfSplat.begin() + s.triangleStart[t + 1], t);
    std::mt19937 random(1);
    const auto signedUnit = [&] { return float(double(random()) * 0x1p-31 - 1); };
    const float shrink = std::sqrt(float(s.count()) / float(count));
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t j = uint32_t(uint64_t(i) * s.count() / count);
        out.splats.uv.push_back(glm::clamp(s.uv[j] + dpl::Vec2f(0.1f * signedUnit(), 0.1f * signedUnit()), 0.0f, 1.0f));
        out.splats.phi.push_back(s.phi[j] + 0.2f * signedUnit());
        out.splats.scaleM.push_back(s.scaleM[j] * shrink);
        out.splats.opacity.push_back(s.opacity[j]);
        out.splats.flags.push_back(s.flags[j]);
        for (size_t k = 0; k < to; ++k) out.splats.sh.push_back((k < from ? s.sh[j * from + k] : 0) + 0.05f * signedUnit());
        triangle.push_back(triangleOfSplat[j]);
    }
    (void)dpl::sortSplats(out, triangle);
    return out;
}

int failed(const std::string& why) {
    return std::fprintf(stderr, "bench_load: %s\n", why.c_str()), 1;
}

}  // namespace

void* operator new(size_t size) {
    return counted(size, 0);
}
void* operator new[](size_t size) {
    return counted(size, 0);
}
void* operator new(size_t size, std::align_val_t a) {
    return counted(size, size_t(a));
}
void* operator new[](size_t size, std::align_val_t a) {
    return counted(size, size_t(a));
}
void operator delete(void* p) noexcept {
    release(p);
}
void operator delete[](void* p) noexcept {
    release(p);
}
void operator delete(void* p, size_t) noexcept {
    release(p);
}
void operator delete[](void* p, size_t) noexcept {
    release(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
    release(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
    release(p);
}
void operator delete(void* p, size_t, std::align_val_t) noexcept {
    release(p);
}
void operator delete[](void* p, size_t, std::align_val_t) noexcept {
    release(p);
}

int main(int argc, char** argv) {
    const dpl::BenchArguments arguments(argc, argv);
    if (arguments.count() < 1)
        return std::fprintf(stderr, "usage: bench_load AVATAR.glb [SPLATS] [SH DEGREE] [BIG.glb | -] [compact] [--json FILE]\n"), 2;
    const uint32_t count = uint32_t(arguments.number(1, 533695)), degree = uint32_t(arguments.number(2, 1));
    const std::string keep = arguments.text(3, "-");
    const bool compact = arguments.text(4) == "compact";
    if (count == 0 || count > (16u << 20) || degree > dpl::kMaxShDegree) return failed("1 to 16777216 splats of SH degree 0 to 3");
    std::vector<uint8_t> file;
    {
        auto bytes = dpl::readFile(arguments.text(0));
        if (!bytes) return failed(bytes.error().message);
        auto avatar = dpl::readAvatar(*bytes);
        if (!avatar) return failed(avatar.error().message);
        if (avatar->splats.count() == 0) return failed("the avatar has no splats");
        dpl::AvatarData big = blownUp(*avatar, count, degree);
        dpl::Jobs jobs(2);
        auto palette = dpl::paletteSh(big.splats, {.maxEntries = 4096, .refinements = 1}, jobs);
        if (!palette) return failed(palette.error().message);
        auto written = dpl::writeAvatar(big, {.shPalette = true, .compact = compact});
        if (!written) return failed(written.error().message);
        file = std::move(*written);
        if (keep != "-")
            if (auto kept = dpl::writeFileAtomically(keep, file); !kept) return failed(kept.error().message);
    }
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 2);
    if (!context) return failed(context.error().message);
    std::vector<double> milliseconds;
    double peakBytes = 0, keptBytes = 0;
    DplFrameStats stats{};
    for (int round = 0; round < 9; ++round) {
        const int64_t before = live;
        peak = before;
        const auto start = std::chrono::steady_clock::now();
        auto avatar = context->loadAvatar(file);
        milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
        if (!avatar) return failed(avatar.error().message);
        peakBytes = double(peak - before), keptBytes = double(live - before);
        auto got = avatar->frameStats();
        if (!got) return failed(got.error().message);
        stats = *got;
    }
    std::sort(milliseconds.begin(), milliseconds.end());
    const double ply = 248.0 * count;
    std::printf("%u splats of SH degree %u, %zu bytes in the file\n", count, degree, file.size());
    std::printf("splats in memory  %9.2f MB  %5.2f B a splat  %5.2f %% of 62 floats a splat\n", double(stats.splatBytes) / 1e6,
                double(stats.splatBytes) / count, 100 * double(stats.splatBytes) / ply);
    std::printf("avatar in memory  %9.2f MB  %5.2f B a splat  %5.2f %%   (counted by the allocator: %.2f MB)\n",
                double(stats.avatarBytes) / 1e6, double(stats.avatarBytes) / count, 100 * double(stats.avatarBytes) / ply, keptBytes / 1e6);
    std::printf("peak of loading   %9.2f MB  %5.2f x what is kept; the file's bytes are the caller's\n", peakBytes / 1e6,
                peakBytes / keptBytes);
    std::printf("load              %9.1f ms median, %.1f fastest, of %zu\n", milliseconds[milliseconds.size() / 2], milliseconds[0],
                milliseconds.size());
    dpl::JsonRow row;
    row.add("device", context->rendererName()).add("splats", count).add("sh_degree", degree);
    row.add("encoding", compact ? "compact" : "plain").add("file_bytes", file.size());
    row.add("splat_bytes", stats.splatBytes).add("avatar_bytes", stats.avatarBytes);
    row.add("splat_share", double(stats.splatBytes) / ply).add("avatar_share", double(stats.avatarBytes) / ply);
    row.add("kept_bytes", uint64_t(keptBytes)).add("peak_bytes", uint64_t(peakBytes)).add("peak_ratio", peakBytes / keptBytes);
    row.add("load_ms", milliseconds[milliseconds.size() / 2]).add("load_ms_fastest", milliseconds[0]);
    const dpl::Status written = arguments.writeJson(row.line());
    return written ? 0 : failed(written.error().message);
}
