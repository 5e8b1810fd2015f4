// SPDX-License-Identifier: Apache-2.0
// Long work that whoever started it may cancel and watch. The work itself is plain functions with loops; they ask taskAt() now and then.
//
//   Task task;                               the starter keeps it, and calls cancel() and progress() from any thread
//   const TaskScope scope(&task);            the thread that works, around all of it
//   { const TaskPart part(0, 0.5); ... }     half of the work
//   DPL_RETURN_IF_ERROR(taskAt(double(i) / n));     in its loops
#pragma once

#include <atomic>
#include <cstddef>
#include <string_view>

#include "sdk/core/result.h"

namespace dpl {

class Task {
public:
    virtual ~Task() = default;
    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
    virtual bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
    /** Share of the work that is done, 0 to 1. It never falls. */
    double progress() const { return progress_.load(std::memory_order_relaxed); }
    /** For the thread that works. */
    void advance(double to) {
        if (to > progress()) progress_.store(to < 1 ? to : 1, std::memory_order_relaxed);
    }
    /** Hears on the thread that works what it is doing ("frame 3 of 20"), and the share of the whole that is done. */
    virtual void hear([[maybe_unused]] double share, [[maybe_unused]] std::string_view doing) {}

private:
    std::atomic<bool> cancelled_{false};
    std::atomic<double> progress_{0};
};

/** Makes `task` the task of this thread until the scope ends. Null: none. */
class TaskScope {
public:
    explicit TaskScope(Task* task);
    ~TaskScope();
    TaskScope(const TaskScope&) = delete;
    TaskScope& operator=(const TaskScope&) = delete;

private:
    Task* before_;
    double from_, to_;  // of the part around it
};

/** What is done until the part ends counts as [from, to] of the part around it. Parts nest. */
class TaskPart {
public:
    TaskPart(double from, double to);
    ~TaskPart();
    TaskPart(const TaskPart&) = delete;
    TaskPart& operator=(const TaskPart&) = delete;

private:
    double from_, to_;  // of the part around it
};

/** For loops: says that `share` (0 to 1) of the part at hand is done, and what is done next, if that is worth telling. Cancelled: the task
 *  of this thread was cancelled. Costs some nanoseconds; without a task it does nothing. */
Status taskAt(double share, std::string_view doing = {});

/** Turns of a loop over splats between two calls of taskAt(), a power of two: about a millisecond. */
constexpr size_t kLook = 4096;

}  // namespace dpl
