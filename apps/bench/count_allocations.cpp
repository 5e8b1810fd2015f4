// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/count_allocations.h"

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace dpl {
namespace {

enum Counting : int { kNobody, kAll, kOwn };
std::atomic<int> counting{kNobody};
thread_local bool own = false;
std::atomic<uint64_t> allocations{0};

void* countedMemory(size_t bytes, size_t alignment = alignof(std::max_align_t)) {
    if (const int who = counting.load(std::memory_order_relaxed); who == kAll || (who == kOwn && own))
        allocations.fetch_add(1, std::memory_order_relaxed);
    void* memory = alignment > alignof(std::max_align_t) ? std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)
                                                         : std::malloc(bytes ? bytes : 1);
    if (!memory) throw std::bad_alloc();
    return memory;
}

}  // namespace

AllocationCount::AllocationCount(CountedThreads threads) : before_(allocations) {
    own = true;
    counting = threads == CountedThreads::All ? kAll : kOwn;
}
AllocationCount::~AllocationCount() {
    stop();
}

uint64_t AllocationCount::stop() {
    counting = kNobody, own = false;
    return allocations - before_;
}

}  // namespace dpl

void* operator new(size_t bytes) {
    return dpl::countedMemory(bytes);
}
void* operator new[](size_t bytes) {
    return dpl::countedMemory(bytes);
}
void* operator new(size_t bytes, std::align_val_t alignment) {
    return dpl::countedMemory(bytes, size_t(alignment));
}
void* operator new[](size_t bytes, std::align_val_t alignment) {
    return dpl::countedMemory(bytes, size_t(alignment));
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, size_t, std::align_val_t) noexcept {
    std::free(memory);
}
