// Counts heap allocations of C++ code in the whole process: of libdoppel and its threads too, whose operator new is the program's. A program that
// links count_allocations.cpp has its own operator new and delete: malloc, and one flag that is looked at.
#pragma once

#include <cstdint>

namespace dpl {

/** Counts from its construction to its end or stop(). One at a time; of all threads. */
class AllocationCount {
public:
    AllocationCount();
    ~AllocationCount();
    AllocationCount(const AllocationCount&) = delete;
    AllocationCount& operator=(const AllocationCount&) = delete;

    /** Ends counting and gives the number since construction. */
    uint64_t stop();

private:
    uint64_t before_;
};

}  // namespace dpl
