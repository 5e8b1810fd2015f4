// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/memory_watch.h"

#ifdef DOPPEL_NO_MEMORY_WATCH

namespace dpl::test {
void startMemoryWatch() {}
uint64_t peakMemoryBytes() {
    return 0;
}
}  // namespace dpl::test

#else

#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

namespace {

int64_t live = 0, peak = 0;  // the driver is single-threaded

void* counted(size_t size) {
    void* p = std::malloc(size ? size : 1);
    if (!p) throw std::bad_alloc();
    live += int64_t(malloc_usable_size(p));
    peak = std::max(peak, live);
    return p;
}
void release(void* p) noexcept {
    if (p) live -= int64_t(malloc_usable_size(p));
    std::free(p);
}

}  // namespace

void* operator new(size_t size) {
    return counted(size);
}
void* operator new[](size_t size) {
    return counted(size);
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

namespace dpl::test {
void startMemoryWatch() {
    live = 0, peak = 0;
}
uint64_t peakMemoryBytes() {
    return uint64_t(peak);
}
}  // namespace dpl::test

#endif
