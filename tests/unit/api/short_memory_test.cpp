// SPDX-License-Identifier: Apache-2.0
// Memory ends anywhere inside a load: the load gives DPL_ERROR_OUT_OF_MEMORY, nothing leaks, and the next load succeeds. This program
// replaces malloc, so that the allocation of a chosen number fails, in libdoppel and in every library that it uses.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>

#include "sdk/core/files.h"
#include "tests/unit/api/api_fixture.h"

namespace {

// A load on this thread alone is watched; renderers with several threads share the count.
std::atomic<bool> watching{false};
std::atomic<int64_t> asked{0}, firstRefused{-1}, live{0};
std::atomic<bool> refuseOn{false};  // refuse all allocations from firstRefused on, not only that one

bool refuse() {
    if (!watching.load(std::memory_order_relaxed)) return false;
    const int64_t number = asked.fetch_add(1), first = firstRefused;
    const bool refused = first >= 0 && (refuseOn ? number >= first : number == first);
    if (refused) errno = ENOMEM;
    return refused;
}

void* counted(void* memory) {
    if (memory) live.fetch_add(1, std::memory_order_relaxed);
    return memory;
}

}  // namespace

// glibc's own functions under their second names. Under a sanitizer, which has a heap of its own, nothing is replaced.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DOPPEL_REPLACED_MALLOC
extern "C" {
void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t count, size_t bytes);
void* __libc_realloc(void* memory, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);
void __libc_free(void* memory);

void* malloc(size_t bytes) {
    return refuse() ? nullptr : counted(__libc_malloc(bytes));
}
void* calloc(size_t count, size_t bytes) {
    return refuse() ? nullptr : counted(__libc_calloc(count, bytes));
}
void* realloc(void* memory, size_t bytes) {
    if (refuse()) return nullptr;
    void* const moved = __libc_realloc(memory, bytes);
    return memory ? moved : counted(moved);
}
void* memalign(size_t alignment, size_t bytes) {
    return refuse() ? nullptr : counted(__libc_memalign(alignment, bytes));
}
void* aligned_alloc(size_t alignment, size_t bytes) {
    return memalign(alignment, bytes);
}
int posix_memalign(void** memory, size_t alignment, size_t bytes) {
    *memory = memalign(alignment, bytes);
    return *memory ? 0 : ENOMEM;
}
void free(void* memory) {
    if (memory) live.fetch_sub(1, std::memory_order_relaxed);
    __libc_free(memory);
}
}
#endif

namespace dpl::test {
namespace {

struct Attempt {
    DplResult result = DPL_OK;
    int64_t allocations = 0;  // that the call asked for
    int64_t kept = 0;         // blocks more at the end than at the beginning
};

/** Runs `call` while allocation `number` is refused, or with `on` that one and all later ones. -1: none. */
template <class Call>
Attempt under(int64_t number, bool on, Call call) {
    Attempt out;
    const int64_t before = live;
    asked = 0, firstRefused = number, refuseOn = on;
    watching = true;
    out.result = call();
    watching = false;
    out.allocations = asked, out.kept = live - before;
    return out;
}

class ShortMemory : public testing::Test {
protected:
    void SetUp() override {
#ifndef DOPPEL_REPLACED_MALLOC
        GTEST_SKIP() << "malloc cannot be replaced here (a sanitizer, or a C library other than glibc)";
#endif
        const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 2};
        ASSERT_EQ(dplCreateContext(&info, &context_), DPL_OK) << dplGetLastError();
        // The first error text and log line of a thread allocate buffers that stay.
        DplAvatar none = nullptr;
        const std::vector<uint8_t> bad(1000, 'x');
        EXPECT_EQ(dplLoadAvatar(context_, bad.data(), bad.size(), &none), DPL_ERROR_UNSUPPORTED);
    }
    void TearDown() override {
        if (context_) {
            EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        }
    }

    static std::vector<uint8_t> corpus(const std::string& name) {
        const char* root = std::getenv("DOPPEL_SOURCE_DIR");
        auto bytes = readFile(std::filesystem::path(root ? root : ".") / "tests/fuzz/corpus" / name);
        EXPECT_TRUE(bytes) << name;
        return bytes ? *bytes : std::vector<uint8_t>{};
    }

    /** Loads the file with every `stride`-th of its allocations refused, alone and with all that follow. */
    void sweepLoad(const std::string& name, const std::vector<uint8_t>& file, int64_t stride = 1) {
        SCOPED_TRACE(name);
        DplAvatar avatar = nullptr;
        const auto load = [&] { return dplLoadAvatar(context_, file.data(), file.size(), &avatar); };
        const auto clean = [&] {
            const Attempt whole = under(-1, false, load);
            EXPECT_EQ(whole.result, DPL_OK) << dplGetLastError();
            EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
            avatar = nullptr;
            return whole.allocations;
        };
        (void)clean();  // fills what stays for the life of the context
        const int64_t allocations = clean();
        ASSERT_GT(allocations, 20);
        int64_t survivedOne = 0, survivedAll = 0, refused = 0;
        for (const bool on : {false, true})
            for (int64_t number = on ? stride / 2 : 0; number < allocations; number += stride) {
                SCOPED_TRACE(testing::Message()
                             << "allocation " << number << (on ? " and all later ones" : " alone") << " of " << allocations);
                const Attempt attempt = under(number, on, load);
                if (attempt.result == DPL_OK) {  // something optional, or the load had memory in reserve
                    ASSERT_EQ(dplDestroyAvatar(avatar), DPL_OK);
                    avatar = nullptr, ++(on ? survivedAll : survivedOne);
                    continue;
                }
                ASSERT_EQ(attempt.result, DPL_ERROR_OUT_OF_MEMORY) << dplGetResultName(attempt.result) << ": " << dplGetLastError();
                ASSERT_EQ(avatar, nullptr);
                ASSERT_LE(attempt.kept, 0) << "blocks leaked";
                if (++refused % 16 == 0) {
                    ASSERT_EQ(clean(), allocations) << "the next load is like the first";
                }
            }
        EXPECT_GT(refused, 16);
        EXPECT_LT(survivedAll, 4) << "loads that went on without any memory";
        std::printf("[   NOTE   ] %s, %lld allocations: %lld loads refused, %lld went on without one of them, %lld without any more\n",
                    name.c_str(), static_cast<long long>(allocations), static_cast<long long>(refused), static_cast<long long>(survivedOne),
                    static_cast<long long>(survivedAll));
    }

    DplContext context_ = nullptr;
};

TEST_F(ShortMemory, endsAnywhereInAnAvatar) {
    sweepLoad("tiny avatar", tinyFile());
    for (const char* name : {"correctives.glb", "small.glb", "small_plain.glb", "palette_plain.glb", "compact_plain.glb"})
        sweepLoad(name, corpus(name), 11);
}

TEST_F(ShortMemory, endsAnywhereInGeneralSplats) {
    for (const char* name : {"splats.ply", "splats.compressed.ply", "splats_v2.spz", "splats_v3.spz", "splats_v4.spz", "splats.glb"})
        sweepLoad(name, corpus(name));
    sweepLoad("splats_khr.glb", corpus("splats_khr.glb"), 5);
}

/** A refused file is refused with its own error, or for lack of memory: nothing else. */
TEST_F(ShortMemory, endsAnywhereInADamagedFile) {
    std::vector<uint8_t> file = tinyFile();
    file.resize(file.size() - 4);
    file[8] = uint8_t(file.size()), file[9] = uint8_t(file.size() >> 8);
    DplAvatar avatar = nullptr;
    const auto load = [&] { return dplLoadAvatar(context_, file.data(), file.size(), &avatar); };
    const Attempt whole = under(-1, false, load);
    ASSERT_EQ(whole.result, DPL_ERROR_CORRUPT_DATA);
    for (const bool on : {false, true})
        for (int64_t number = 0; number < whole.allocations; ++number) {
            const Attempt attempt = under(number, on, load);
            ASSERT_TRUE(attempt.result == DPL_ERROR_CORRUPT_DATA || attempt.result == DPL_ERROR_OUT_OF_MEMORY)
                << dplGetResultName(attempt.result) << " at allocation " << number;
            ASSERT_LE(attempt.kept, 0) << "blocks leaked at allocation " << number;
        }
}

}  // namespace
}  // namespace dpl::test
