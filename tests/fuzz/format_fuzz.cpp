// SPDX-License-Identifier: Apache-2.0
// Fuzz target of the format readers. No input may crash. An accepted avatar must be writable, and writing it again must give the same
// bytes. LLVMFuzzerTestOneInput is called by libFuzzer, or by fuzz_driver.cpp without clang.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "sdk/format/avatar_file.h"
#include "sdk/format/skinned_gltf.h"
#include "sdk/format/splat_file.h"
#include "tests/fuzz/memory_watch.h"

namespace {

void mustHold(bool condition, const char* what) {
    if (condition) return;
    std::fprintf(stderr, "fuzz: %s\n", what);
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::span<const uint8_t> bytes(data, size);
    if (const dpl::SplatFormat format = dpl::splatFormatOf(bytes); format != dpl::SplatFormat::None) {
        dpl::test::startMemoryWatch();
        auto splats = dpl::readSplats(bytes);
        mustHold(dpl::test::peakMemoryBytes() <= (64ull << 20) + 1280 * uint64_t(size),
                 "readSplats took more memory than splat_file.h promises");
        mustHold(splats || !splats.error().message.empty(), "an error without a sentence");
        if (format != dpl::SplatFormat::Gltf) return 0;  // glTF also goes to the other readers
    }
    dpl::ReadLimits limits;
    limits.verifyHash = false;  // otherwise the hash check would refuse every mutation
    dpl::test::startMemoryWatch();
    auto avatar = dpl::readAvatar(bytes, limits);
    const uint64_t peak = dpl::test::peakMemoryBytes();
    mustHold(peak <= (64ull << 20) + (64 + 1024) * uint64_t(size), "readAvatar took more memory than avatar_file.h promises");
    mustHold(avatar || !avatar.error().message.empty(), "an error without a sentence");
    if (avatar) {
        const dpl::WriteOptions ways[] = {
            {}, {.shPalette = true}, {.shPalette = true, .compact = true}, {.compact = true, .bits = {8, 7, 8, 6, 8}}};
        for (const dpl::WriteOptions& way : ways) {
            auto written = dpl::writeAvatar(*avatar, way);
            mustHold(bool(written), "an accepted avatar cannot be written");
            auto again = dpl::readAvatar(*written);
            mustHold(bool(again), "a written avatar cannot be read");
            auto rewritten = dpl::writeAvatar(*again, way);
            mustHold(rewritten && *rewritten == *written, "writing is not idempotent");
        }
    }
    dpl::SkinnedGltfOptions options;
    options.requireSkin = false;
    (void)dpl::readSkinnedGltf(bytes, options);
    return 0;
}
