// SPDX-License-Identifier: Apache-2.0
// Whether uses of untracked resources are ordered. Metal runs the encoders of a queue, and the dispatches of a concurrent encoder, at once,
// unless a fence, a barrier, an event or the CPU orders them.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace dpl::mtl {

/** A stage of an encoder: 2 × its number, + 1 for the fragment stage. */
using Scope = uint64_t;
/** Scopes that have ended before something begins. */
using Ended = std::set<Scope>;

/** Where a command stands. */
struct Place {
    Scope scope = 0;
    uint32_t interval = 0;         // between barriers of the encoder
    uint64_t commands = 0;         // number of its command buffer, in the order of commits
    uint64_t seenCommands = 0;     // the CPU had seen the end of the command buffers up to this one when it committed this one
    const Ended* ended = nullptr;  // before the scope
    std::string what;              // for messages
};

class Hazards {
public:
    /** A use of bytes of a buffer or of slices of a texture, from `begin` to before `end`. Returns a sentence when it is not ordered behind
     * an earlier use, else nothing. */
    std::string use(const void* resource, uint64_t begin, uint64_t end, bool writes, const Place& place);
    void forget(const void* resource);

private:
    struct Use {
        Place place;
        uint64_t begin, end;
        bool writes;
    };
    std::map<const void*, std::vector<Use>> uses_;  // those that a later use may have to wait for
};

}  // namespace dpl::mtl
