// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/task.h"

namespace dpl {
namespace {

struct Current {
    Task* task = nullptr;
    double from = 0, to = 1;  // the part at hand, of the whole
};
thread_local Current current;

}  // namespace

TaskScope::TaskScope(Task* task) : before_(current.task) {
    current.task = task;
}

TaskScope::~TaskScope() {
    current.task = before_;
}

TaskPart::TaskPart(double from, double to) : from_(current.from), to_(current.to) {
    const double size = current.to - current.from;
    current.to = current.from + to * size;
    current.from += from * size;
    if (current.task) current.task->advance(current.from);
}

TaskPart::~TaskPart() {
    current.from = from_, current.to = to_;
}

Status taskAt(double share) {
    if (!current.task) return {};
    if (current.task->cancelled()) return fail(Code::Cancelled, "cancelled");
    current.task->advance(current.from + share * (current.to - current.from));
    return {};
}

}  // namespace dpl
