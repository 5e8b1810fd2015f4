// SPDX-License-Identifier: Apache-2.0
// A fixed pool of worker threads and the one parallel loop that everything uses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "sdk/core/function_ref.h"

namespace dpl {

/** A pool of `threadCount` threads, the caller's included. Results must not depend on which worker runs which block:
 *  split work into blocks of fixed shape and reduce them in block order, and any thread count gives the same bytes. */
class Jobs {
public:
    /** threadCount 0: one thread per core. */
    explicit Jobs(uint32_t threadCount = 0);
    ~Jobs();
    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    uint32_t threadCount() const;

    /** Calls body(block, worker) for each block in [0, blockCount), worker < threadCount(). Blocks are handed out in
     *  order by an atomic counter. Returns when all are done. Allocates nothing. Not re-entrant: one loop at a time per pool. */
    void forBlocks(size_t blockCount, FunctionRef<void(size_t block, uint32_t worker)> body);

    /** Splits [0, count) into blocks of `grain` and calls body(begin, end, worker) for each. */
    void forRange(size_t count, size_t grain, FunctionRef<void(size_t begin, size_t end, uint32_t worker)> body);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dpl
