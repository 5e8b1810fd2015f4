// SPDX-License-Identifier: Apache-2.0
// The radix sort on the device against std::stable_sort. CMake runs it at lavapipe's vector widths 128, 256 and 512 (subgroups of
// 4, 8 and 16 lanes): a kernel that assumes a subgroup width fails at one of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>

#include "sdk/render/passes/scan.h"
#include "sdk/render/passes/sort.h"
#include "tests/unit/render/vulkan_test_device.h"

namespace dpl {
namespace {

using Pairs = std::vector<gpu::SortPair>;

/** rounds: 2, 3 or 4 digits of the key. */
std::vector<uint32_t> sortOnDevice(Backend& backend, const Pairs& input, uint32_t rounds) {
    FrameIds ids;
    ids.wide = rounds == gpu::kWideSortRounds;
    EXPECT_EQ(ids.sortRounds(), rounds);
    ids.allSplats = uint32_t(std::max<size_t>(input.size(), 1));
    const auto make = [&](const char* label, uint64_t bytes, BufferMemory memory = BufferMemory::Device) {
        auto buffer = backend.createBuffer({label, std::max<uint64_t>(bytes, 16), memory});
        EXPECT_TRUE(buffer);
        return *buffer;
    };
    ids.counts = make("counts", sizeof(gpu::FrameCounts));
    ids.pairs = make("pairs", ids.allSplats * uint64_t(sizeof(gpu::SortPair)));
    ids.pairsSwap = make("swap", ids.allSplats * uint64_t(sizeof(gpu::SortPair)));
    ids.digits = {make("cells", ids.digitWords() * 4), make("sums", scanSumWords(gpu::kSortDigits) * 4),
                  make("places", ids.digitWords() * 4)};
    const BufferId result = make("result", ids.allSplats * 4ull, BufferMemory::Readback);
    gpu::FrameCounts counts{};
    counts.visible = uint32_t(input.size());
    counts.runs = (counts.visible + gpu::kRun - 1) / gpu::kRun;
    counts.runGroupsX = counts.runs;
    counts.runGroupsY = counts.runGroupsZ = 1;
    EXPECT_TRUE(backend.write(ids.counts, 0, std::as_bytes(std::span(&counts, 1))));
    EXPECT_TRUE(backend.write(ids.unsorted(), 0, std::as_bytes(std::span(input))));
    FramePlan plan(backend);
    addSort(plan, ids);
    plan.copy("result", ids.pairs, result);
    auto frame = plan.finish();
    EXPECT_TRUE(frame) << (frame ? "" : frame.error().message);
    EXPECT_TRUE(backend.run(*frame));
    std::vector<uint32_t> sorted(input.size());
    if (!sorted.empty()) std::memcpy(sorted.data(), backend.mapped(result).data(), sorted.size() * 4);
    backend.destroyFrame(*frame);
    for (BufferId id : {ids.counts, ids.pairs, ids.pairsSwap, ids.digits.cells, ids.digits.sums, ids.digits.places, result})
        backend.destroyBuffer(id);
    return sorted;
}

TEST(VulkanSort, equalsStableSort) {
    const VulkanTestOptions options = testVulkanOptions();
    auto backend = createTestBackend(options);
    if (!backend) GTEST_SKIP() << backend.error().message;
    const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH");
    std::printf("[  DEVICE  ] %s, LP_NATIVE_VECTOR_WIDTH=%s\n", (*backend)->info().name.c_str(), width ? width : "default");
    std::mt19937 random(11);
    for (size_t count : {size_t(0), size_t(1), size_t(2), size_t(127), size_t(gpu::kRun - 1), size_t(gpu::kRun), size_t(gpu::kRun + 1),
                         size_t(30011), size_t(100000)}) {
        for (uint32_t rounds : {gpu::kSortRounds, gpu::kWideSortRounds}) {
            for (uint32_t keys : {1u, 7u, 1u << rounds * gpu::kSortDigitBits}) {  // all keys equal, many ties, few ties
                Pairs input(count);
                for (size_t i = 0; i < count; ++i) input[i] = {uint32_t(random() % keys), uint32_t(i)};
                Pairs want = input;
                std::stable_sort(want.begin(), want.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
                const std::vector<uint32_t> got = sortOnDevice(**backend, input, rounds);
                EXPECT_TRUE(std::equal(want.begin(), want.end(), got.begin(), got.end(),
                                       [](const gpu::SortPair& pair, uint32_t splat) { return pair.splat == splat; }))
                    << count << " pairs, " << keys << " keys, " << rounds << " rounds";
            }
        }
    }
    backend->reset();
    EXPECT_EQ(options.validationMessages->load(), 0u);
}

}  // namespace
}  // namespace dpl
