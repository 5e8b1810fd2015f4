#include "sdk/core/jobs.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace dpl {

struct Jobs::State {
    std::vector<std::thread> threads;
    std::mutex mutex;
    std::condition_variable wake, done;
    const FunctionRef<void(size_t, uint32_t)>* body = nullptr;
    std::atomic<size_t> next{0};
    size_t blockCount = 0;
    uint64_t generation = 0;
    uint32_t running = 0;
    bool quit = false;

    void drain(uint32_t worker) {
        for (size_t block = next.fetch_add(1); block < blockCount; block = next.fetch_add(1)) (*body)(block, worker);
    }

    void workerLoop(uint32_t worker) {
        uint64_t seen = 0;
        for (;;) {
            {
                std::unique_lock lock(mutex);
                wake.wait(lock, [&] { return generation != seen || quit; });
                if (quit) return;
                seen = generation;
            }
            drain(worker);
            std::lock_guard lock(mutex);
            if (--running == 0) done.notify_one();
        }
    }
};

Jobs::Jobs(uint32_t threadCount) : state_(std::make_unique<State>()) {
    if (threadCount == 0) threadCount = std::max(1u, std::thread::hardware_concurrency());
    try {
        for (uint32_t worker = 1; worker < threadCount; ++worker)
            state_->threads.emplace_back([state = state_.get(), worker] { state->workerLoop(worker); });
    } catch (const std::system_error&) {
        // The system grants no more threads: the pool works with those it has, and results do not depend on how many.
    }
}

Jobs::~Jobs() {
    {
        std::lock_guard lock(state_->mutex);
        state_->quit = true;
    }
    state_->wake.notify_all();
    for (std::thread& thread : state_->threads) thread.join();
}

uint32_t Jobs::threadCount() const { return uint32_t(state_->threads.size()) + 1; }

void Jobs::forBlocks(size_t blockCount, FunctionRef<void(size_t, uint32_t)> body) {
    if (blockCount == 0) return;
    State& s = *state_;
    if (s.threads.empty() || blockCount == 1) {
        for (size_t block = 0; block < blockCount; ++block) body(block, 0);
        return;
    }
    {
        std::lock_guard lock(s.mutex);
        s.body = &body;
        s.blockCount = blockCount;
        s.next = 0;
        s.running = uint32_t(s.threads.size());
        ++s.generation;
    }
    s.wake.notify_all();
    s.drain(0);
    std::unique_lock lock(s.mutex);
    s.done.wait(lock, [&] { return s.running == 0; });
}

void Jobs::forRange(size_t count, size_t grain, FunctionRef<void(size_t, size_t, uint32_t)> body) {
    grain = std::max<size_t>(1, grain);
    forBlocks((count + grain - 1) / grain, [&](size_t block, uint32_t worker) {
        body(block * grain, std::min(count, (block + 1) * grain), worker);
    });
}

}  // namespace dpl
