// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/jobs.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace dpl {

namespace {

/** How often a waiting thread polls before it sleeps, about 30 µs. A training step or a frame has some twenty short loops, and waking a
 *  sleeping thread takes as long as the shortest of them. */
constexpr int kLooks = 1000;

void relax() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__) || defined(__arm__)
    asm volatile("yield");
#endif
}

}  // namespace

struct Jobs::State {
    std::vector<std::thread> threads;
    std::mutex mutex;
    std::condition_variable wake, done;
    const FunctionRef<void(size_t, uint32_t)>* body = nullptr;
    std::atomic<size_t> next{0};
    size_t blockCount = 0;
    std::atomic<uint64_t> generation{0};  // counts the loops; changed under the mutex, after all other fields
    std::atomic<uint32_t> running{0};
    std::atomic<bool> quit{false};
    int looks = 0;  // 0 if there are more threads than cores: polling would keep another thread from working

    /** Polls ready(); false if it did not become true within `looks` polls. */
    template <class Ready>
    bool soon(Ready&& ready) const {
        for (int look = 0; look < looks; ++look) {
            if (ready()) return true;
            relax();
        }
        return false;
    }

    void drain(uint32_t worker) {
        for (size_t block = next.fetch_add(1); block < blockCount; block = next.fetch_add(1)) (*body)(block, worker);
    }

    void workerLoop(uint32_t worker) {
        uint64_t seen = 0;
        const auto called = [&] { return generation.load() != seen || quit.load(); };
        for (;;) {
            if (!soon(called)) {
                std::unique_lock lock(mutex);
                wake.wait(lock, called);
            }
            if (quit.load()) return;
            seen = generation.load();
            drain(worker);
            if (running.fetch_sub(1) == 1) {
                std::lock_guard lock(mutex);  // so that the caller either sees 0 before it waits, or waits already and is woken
                done.notify_one();
            }
        }
    }
};

Jobs::Jobs(uint32_t threadCount) : state_(std::make_unique<State>()) {
    const uint32_t cores = std::max(1u, std::thread::hardware_concurrency());
    if (threadCount == 0) threadCount = cores;
    state_->looks = threadCount <= cores ? kLooks : 0;
    try {
        for (uint32_t worker = 1; worker < threadCount; ++worker)
            state_->threads.emplace_back([state = state_.get(), worker] { state->workerLoop(worker); });
    } catch (const std::system_error&) {
        // The system grants no more threads. The pool works with those it has; results do not depend on their number.
    }
}

Jobs::~Jobs() {
    {
        std::lock_guard lock(state_->mutex);
        state_->quit.store(true);
    }
    state_->wake.notify_all();
    for (std::thread& thread : state_->threads) thread.join();
}

uint32_t Jobs::threadCount() const {
    return uint32_t(state_->threads.size()) + 1;
}

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
        s.next.store(0);
        s.running.store(uint32_t(s.threads.size()));
        s.generation.fetch_add(1);
    }
    s.wake.notify_all();
    s.drain(0);
    const auto finished = [&] { return s.running.load() == 0; };
    if (s.soon(finished)) return;
    std::unique_lock lock(s.mutex);
    s.done.wait(lock, finished);
}

void Jobs::forRange(size_t count, size_t grain, FunctionRef<void(size_t, size_t, uint32_t)> body) {
    grain = std::max<size_t>(1, grain);
    forBlocks((count + grain - 1) / grain,
              [&](size_t block, uint32_t worker) { body(block * grain, std::min(count, (block + 1) * grain), worker); });
}

}  // namespace dpl
