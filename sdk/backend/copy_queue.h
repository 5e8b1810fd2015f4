// SPDX-License-Identifier: Apache-2.0
// Copies between buffers that wait for the GPU: uploads in the background of frames.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sdk/backend/backend.h"

namespace dpl {

/** Copies that have not run, in their order. The commands of an app carry them in its slots; on a device of the backend's own the front
 *  one is submitted by itself. */
class CopyQueue {
public:
    static constexpr uint32_t kNoSlot = UINT32_MAX;
    struct Copy {
        uint64_t number = 0;
        BufferId from, to;
        uint64_t fromOffset = 0, toOffset = 0, bytes = 0;
        bool running = false;     // submitted, or encoded with `slot`
        uint32_t slot = kNoSlot;  // of an app
    };

    /** Whether a buffer with that many bytes has [offset, offset + bytes); offsets are multiples of 4. */
    static bool fits(uint64_t bufferBytes, uint64_t offset, uint64_t bytes) {
        return bytes > 0 && offset % 4 == 0 && offset <= bufferBytes && bytes <= bufferBytes - offset;
    }
    /** Returns the number of the copy. */
    uint64_t add(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) {
        copies_.push_back({++last_, from, to, fromOffset, toOffset, bytes});
        return last_;
    }
    /** nullptr: it has run. */
    const Copy* find(uint64_t number) const {
        const auto it = std::find_if(copies_.begin(), copies_.end(), [&](const Copy& c) { return c.number == number; });
        return it == copies_.end() ? nullptr : &*it;
    }
    /** nullptr: none waits. */
    Copy* front() { return copies_.empty() ? nullptr : &copies_.front(); }
    /** The front one has run. */
    void pop() { copies_.erase(copies_.begin()); }

    bool anyToEncode() const {
        return std::any_of(copies_.begin(), copies_.end(), [](const Copy& c) { return !c.running; });
    }
    /** Calls `encode` for the copies that are not encoded yet: at least one, and no more than kCopiedBytesAFrame together. */
    template <class Encode>
    Status encodeWith(uint32_t slot, const Encode& encode) {
        uint64_t bytes = 0;
        for (Copy& copy : copies_) {
            if (copy.running) continue;
            if (bytes > 0 && bytes + copy.bytes > kCopiedBytesAFrame) break;
            DPL_RETURN_IF_ERROR(encode(copy));
            bytes += copy.bytes;
            copy.running = true;
            copy.slot = slot;
        }
        return {};
    }
    /** The commands with this slot have run. */
    void slotHasRun(uint32_t slot) {
        std::erase_if(copies_, [&](const Copy& c) { return c.running && c.slot == slot; });
    }
    /** The commands with this slot may never run: the next frame has the copies again. */
    void slotIsDropped(uint32_t slot) {
        for (Copy& copy : copies_)
            if (copy.slot == slot) copy.running = false;
    }
    static bool uses(const Copy& copy, BufferId buffer) { return copy.from == buffer || copy.to == buffer; }
    /** Forgets the copies from or to a buffer that is about to go. An app's commands may still have them. */
    void drop(BufferId buffer) {
        std::erase_if(copies_, [&](const Copy& c) { return uses(c, buffer); });
    }

private:
    std::vector<Copy> copies_;
    uint64_t last_ = 0;
};

}  // namespace dpl
