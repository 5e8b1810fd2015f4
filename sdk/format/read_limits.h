// SPDX-License-Identifier: Apache-2.0
// Limits that readers check before they allocate. The defaults are far above expected avatars and far below the memory of a machine.
#pragma once

#include <cstdint>

namespace dpl {

struct ReadLimits {
    uint64_t maxFileBytes = 2ull << 30;
    uint32_t maxJsonBytes = 16u << 20;
    uint32_t maxJsonDepth = 64;
    uint32_t maxJsonValues = 2u << 20;  // keys, scalars, arrays and objects together
    uint32_t maxVertices = 4u << 20;
    uint32_t maxTriangles = 8u << 20;
    uint32_t maxSplats = 16u << 20;
    uint32_t maxJoints = 1024;
    uint32_t maxNodes = 16384;
    bool verifyHash = true;  // false only for tools that inspect edited files, and for the fuzzer
};

}  // namespace dpl
