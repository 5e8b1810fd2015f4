// SPDX-License-Identifier: Apache-2.0
// Counts heap allocations of C++ code in the whole process, including libdoppel and its threads. In a program that links it,
// count_allocations.cpp replaces operator new and delete by malloc and free plus a check of one flag.
#pragma once

#include <cstdint>

namespace dpl {

/** Own counts only the thread that created the AllocationCount. A CPU Vulkan driver compiles kernels on its own threads at any time, and
 * Own leaves those allocations out. */
enum class CountedThreads { All, Own };

/** Counts from construction until stop() or destruction. Only one may exist at a time. */
class AllocationCount {
public:
    explicit AllocationCount(CountedThreads threads = CountedThreads::All);
    ~AllocationCount();
    AllocationCount(const AllocationCount&) = delete;
    AllocationCount& operator=(const AllocationCount&) = delete;

    /** Ends counting and returns the number of allocations since construction. */
    uint64_t stop();

private:
    uint64_t before_;
};

}  // namespace dpl
