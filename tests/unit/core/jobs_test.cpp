// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/jobs.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

#include "sdk/core/reader.h"

namespace {

using namespace dpl;

TEST(Jobs, everyBlockRunsOnceOnAnyThreadCount) {
    for (uint32_t threads : {1u, 2u, 3u, 7u}) {
        Jobs jobs(threads);
        EXPECT_EQ(jobs.threadCount(), threads);
        for (size_t count : {size_t(0), size_t(1), size_t(5), size_t(1000)}) {
            std::vector<int> hits(count, 0);
            jobs.forBlocks(count, [&](size_t block, uint32_t worker) {
                ASSERT_LT(worker, threads);
                ++hits[block];
            });
            for (int hit : hits) EXPECT_EQ(hit, 1);
        }
    }
}

TEST(Jobs, rangesCoverEverythingWithoutOverlap) {
    Jobs jobs(3);
    std::vector<int> hits(1001, 0);
    jobs.forRange(hits.size(), 64, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) ++hits[i];
    });
    for (int hit : hits) EXPECT_EQ(hit, 1);
}

TEST(Jobs, loopsInARowAndLoopsAfterASleepAllFinish) {
    for (uint32_t threads : {2u, 5u}) {  // at most as many as cores; more (on 2 to 4 cores)
        Jobs jobs(threads);
        std::vector<uint32_t> sums(37, 0);
        uint32_t loops = 0;
        for (int round = 0; round < 400; ++round) {
            if (round % 100 == 99)
                std::this_thread::sleep_for(std::chrono::milliseconds(2));  // longer than the 30 µs for which workers poll
            const size_t count = size_t(round) % (sums.size() + 1);
            jobs.forBlocks(count, [&](size_t block, uint32_t) { sums[block] += uint32_t(block) + 1; });
            for (size_t block = 0; block < count; ++block) loops += uint32_t(block) + 1;
        }
        EXPECT_EQ(std::accumulate(sums.begin(), sums.end(), 0u), loops) << threads << " threads";
        EXPECT_GT(loops, 0u);
    }
}

TEST(Reader, refusesToReadPastTheEnd) {
    const uint8_t bytes[6] = {1, 0, 0, 0, 2, 0};
    Reader reader{bytes};
    auto first = reader.u32();
    ASSERT_TRUE(first);
    EXPECT_EQ(*first, 1u);
    EXPECT_EQ(reader.remaining(), 2u);
    auto second = reader.u32();
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Code::CorruptData);
    EXPECT_EQ(reader.remaining(), 2u);
}

TEST(Result, formatsHolesInOrder) {
    EXPECT_EQ(formatText("{} of {} {}", 1, 2.5, "x"), "1 of 2.5 x");
    EXPECT_EQ(formatText("no holes", 1), "no holes");
    EXPECT_EQ(formatText("left {} {}", 1), "left 1 {}");
}

}  // namespace
