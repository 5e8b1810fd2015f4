// SPDX-License-Identifier: Apache-2.0
// Counts heap allocations of C++ code in the whole process, libdoppel and its threads included. count_allocations.cpp replaces operator new
// and delete of the program that links it by malloc with a check of one flag.
#pragma once

#include <cstdint>

namespace dpl {

/** Own: only the thread that counts. A Vulkan driver on the CPU compiles kernels on its own threads at any time; those allocations are not
 *  the frame's. */
enum class CountedThreads { All, Own };

/** Counts from its construction until stop() or its destruction. One at a time. */
class AllocationCount {
public:
    explicit AllocationCount(CountedThreads threads = CountedThreads::All);
    ~AllocationCount();
    AllocationCount(const AllocationCount&) = delete;
    AllocationCount& operator=(const AllocationCount&) = delete;

    /** Ends counting and gives the number since construction. */
    uint64_t stop();

private:
    uint64_t before_;
};

}  // namespace dpl
