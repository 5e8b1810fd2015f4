// SPDX-License-Identifier: Apache-2.0
// Decides where a frame needs barriers: before each step that touches what an earlier step wrote, or writes what an earlier step read.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "sdk/backend/backend.h"

namespace dpl {

/** To be asked for each step of a frame, in order. */
class Hazards {
public:
    bool before(const FillStep& step) { return touch({{step.buffer, true}}); }
    bool before(const ComputeStep& step) { return touch(accessesOf(step.bindings, step.indirect)); }
    bool before(const DrawStep& step) { return touch(accessesOf(step.bindings, step.args)); }
    bool before(const ReadbackStep&) { return false; }  // what draws the target orders its images
    bool before(const CopyStep& step) { return touch({{step.from, false}, {step.to, true}}); }

private:
    using Accesses = std::vector<std::pair<BufferId, bool>>;  // buffer, whether it is written

    static Accesses accessesOf(const std::vector<Binding>& bindings, const IndirectArgs& args) {
        Accesses list;
        for (const Binding& b : bindings) list.push_back({b.buffer, b.access == Access::Write || b.access == Access::Update});
        if (args.buffer) list.push_back({args.buffer, false});
        return list;
    }

    bool touch(const Accesses& accesses) {
        bool hazard = false;
        for (const auto& [buffer, writes] : accesses) hazard |= written_.count(buffer.value) || (writes && read_.count(buffer.value));
        if (hazard) read_.clear(), written_.clear();
        for (const auto& [buffer, writes] : accesses) (writes ? written_ : read_).insert(buffer.value);
        return hazard;
    }

    std::set<uint32_t> read_, written_;  // since the last barrier
};

}  // namespace dpl
