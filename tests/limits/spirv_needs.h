// SPDX-License-Identifier: Apache-2.0
// What a shader demands of the device, read from its SPIR-V.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace dpl::limits {

struct SpirvNeeds {
    std::vector<uint32_t> capabilities;
    uint32_t groupLanes[3] = {0, 0, 0};  // of a compute shader, when written as numbers
};

/** Reads the instructions before the first function. Words that are no SPIR-V demand nothing. */
inline SpirvNeeds needsOf(std::span<const uint32_t> words) {
    constexpr uint32_t kOpExecutionMode = 16, kOpCapability = 17, kOpFunction = 54, kLocalSize = 17;
    SpirvNeeds needs;
    for (size_t at = 5; at < words.size();) {
        const uint32_t op = words[at] & 0xffff, length = words[at] >> 16;
        if (length == 0 || length > words.size() - at || op == kOpFunction) break;
        if (op == kOpCapability && length == 2) needs.capabilities.push_back(words[at + 1]);
        if (op == kOpExecutionMode && length == 6 && words[at + 2] == kLocalSize)
            for (uint32_t axis = 0; axis < 3; ++axis) needs.groupLanes[axis] = words[at + 3 + axis];
        at += length;
    }
    return needs;
}

}  // namespace dpl::limits
