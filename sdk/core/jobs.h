// SPDX-License-Identifier: Apache-2.0
// A fixed pool of worker threads with parallel loops.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "sdk/core/function_ref.h"

namespace dpl {

/** A pool of `threadCount` threads, the caller's included. Results must not depend on the number of threads: split work into blocks of
 *  fixed size and reduce them in block order. */
class Jobs {
public:
    /** threadCount 0: one thread per core. */
    explicit Jobs(uint32_t threadCount = 0);
    ~Jobs();
    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    uint32_t threadCount() const;

    /** Calls body(block, worker) for each block in [0, blockCount), worker < threadCount(). Blocks start in order.
     *  Returns when all are done. Allocates nothing. Not re-entrant: a pool runs one loop at a time. */
    void forBlocks(size_t blockCount, FunctionRef<void(size_t block, uint32_t worker)> body);

    /** Splits [0, count) into blocks of `grain` and calls body(begin, end, worker) for each. */
    void forRange(size_t count, size_t grain, FunctionRef<void(size_t begin, size_t end, uint32_t worker)> body);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dpl
