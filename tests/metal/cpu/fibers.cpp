// SPDX-License-Identifier: Apache-2.0
#include <ucontext.h>

#include "tests/metal/cpu/msl_entry.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

namespace msl {
namespace {

constexpr size_t kStackBytes = 128 * 1024;

struct Fiber {
    ucontext_t context{};
    std::unique_ptr<char[]> stack;
    bool done = false;
};

struct Group {
    std::vector<Fiber> fibers;
    ucontext_t scheduler{};
    Fiber* current = nullptr;
    uint32_t currentLane = 0;
    const std::function<void(uint32_t)>* body = nullptr;
};

Group group;  // one threadgroup at a time, from one CPU thread

void enter() {
    (*group.body)(group.currentLane);
    group.current->done = true;
    swapcontext(&group.current->context, &group.scheduler);
}

}  // namespace

bool runGroup(uint32_t lanes, int order, const std::function<void(uint32_t lane)>& body) {
    group.body = &body;
    if (group.fibers.size() < lanes) group.fibers.resize(lanes);
    for (uint32_t lane = 0; lane < lanes; ++lane) {
        Fiber& f = group.fibers[lane];
        if (!f.stack) f.stack = std::make_unique<char[]>(kStackBytes);
        f.done = false;
        getcontext(&f.context);
        f.context.uc_stack.ss_sp = f.stack.get();
        f.context.uc_stack.ss_size = kStackBytes;
        f.context.uc_link = nullptr;
        makecontext(&f.context, enter, 0);
    }
    std::vector<uint32_t> lanesInOrder(lanes);
    std::iota(lanesInOrder.begin(), lanesInOrder.end(), 0u);
    if (order == 1) std::reverse(lanesInOrder.begin(), lanesInOrder.end());
    std::mt19937 random(5);
    for (;;) {  // each round runs every lane to its next barrier or to its end
        if (order == 2) std::shuffle(lanesInOrder.begin(), lanesInOrder.end(), random);
        uint32_t ended = 0;
        for (uint32_t lane : lanesInOrder) {
            Fiber& f = group.fibers[lane];
            if (f.done) return false;  // it ended in an earlier round while others wait at a barrier
            group.current = &f;
            group.currentLane = lane;
            swapcontext(&group.scheduler, &f.context);
            ended += f.done;
        }
        if (ended == lanes) return true;
        if (ended != 0) return false;
    }
}

void barrier() {
    swapcontext(&group.current->context, &group.scheduler);
}

}  // namespace msl
