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

TaskScope::TaskScope(Task* task) : before_(current.task), from_(current.from), to_(current.to) {
    current = {task, 0, 1};
}

TaskScope::~TaskScope() {
    current = {before_, from_, to_};
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

Status taskAt(double share, std::string_view doing) {
    if (!current.task) return {};
    if (current.task->cancelled()) return fail(Code::Cancelled, "cancelled");
    const double done = current.from + share * (current.to - current.from);
    current.task->advance(done);
    if (!doing.empty()) current.task->hear(done, doing);
    return {};
}

}  // namespace dpl
