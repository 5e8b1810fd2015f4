// SPDX-License-Identifier: Apache-2.0
// Counts heap allocations of C++ code in the whole process: of libdoppel and its threads too, whose operator new is the program's. A
// program that links count_allocations.cpp has its own operator new and delete: malloc, and one flag that is looked at.
#pragma once

#include <cstdint>

namespace dpl {

/** Own: of the thread that counts. A driver that plays the GPU compiles kernels on threads of its own whenever it likes, which is no
 * allocation of a frame. */
enum class CountedThreads { All, Own };

/** Counts from its construction to its end or stop(). One at a time. */
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
