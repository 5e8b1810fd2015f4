// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/software/hazards.h"

#include <algorithm>

namespace dpl::mtl {
namespace {

bool ordered(const Place& before, const Place& after) {
    if (before.commands <= after.seenCommands) return true;
    if (before.scope == after.scope) return before.interval < after.interval;
    return after.ended->count(before.scope) > 0;
}

}  // namespace

std::string Hazards::use(const void* resource, uint64_t begin, uint64_t end, bool writes, const Place& place) {
    std::vector<Use>& uses = uses_[resource];
    std::erase_if(uses, [&](const Use& use) { return use.place.commands <= place.seenCommands; });
    std::string fault;
    for (const Use& use : uses)
        if ((use.writes || writes) && use.begin < end && begin < use.end && !ordered(use.place, place) && fault.empty())
            fault = place.what + (writes ? " writes" : " reads") + " what " + use.place.what + (use.writes ? " writes" : " reads") +
                    ", without a barrier or fence between";
    std::erase_if(uses, [&](const Use& use) {
        const bool covered = use.begin >= begin && use.end <= end;
        const bool together = use.place.scope == place.scope && use.place.interval == place.interval;
        return covered && (writes || (!use.writes && together));
    });
    uses.push_back({place, begin, end, writes});
    uses.back().place.ended = nullptr;  // only needed of the later use
    return fault;
}

void Hazards::forget(const void* resource) {
    uses_.erase(resource);
}

}  // namespace dpl::mtl
