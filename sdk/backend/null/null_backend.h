// SPDX-License-Identifier: Apache-2.0
// A backend without a GPU: checks every frame as the others do, moves no pixels, and remembers what ran.
#pragma once

#include <memory>

#include "sdk/backend/backend.h"

namespace dpl {

struct NullOptions {
    DeviceInfo info = {.name = "null",
                       .kind = DeviceKind::Software,
                       .maxBindingBytes = 128u << 20,
                       .maxTargetPx = 8192,
                       .maxGroups = 65535,
                       .multiview = true,
                       .fourSamples = true};
};

/** What a test may ask afterwards. Owned by the test, shared with the backend. */
struct NullRecord {
    uint64_t liveBuffers = 0, liveTargets = 0, liveFrames = 0, createdObjects = 0, runs = 0;
    uint64_t waits = 0;                   // for a frame that was still running
    bool holdFrames = false;              // set by the test: frames run until they are waited for
    std::vector<std::string> lastLabels;  // of the last frame that ran
};

/** Fails like a real one when the embedded shader pack does not fit. */
Result<std::unique_ptr<Backend>> createNullBackend(std::shared_ptr<NullRecord> record, const NullOptions& options = {});

}  // namespace dpl
