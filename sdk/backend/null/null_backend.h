// SPDX-License-Identifier: Apache-2.0
// A backend without a GPU for tests. It checks every frame as the other backends do, draws no pixels, and remembers what ran.
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

/** What a test can read after frames have run. Shared by the test and the backend. */
struct NullRecord {
    uint64_t liveBuffers = 0, liveTargets = 0, liveFrames = 0, createdObjects = 0, runs = 0;
    uint64_t waits = 0;                   // waits for a frame that was still running
    bool holdFrames = false;              // set by the test: a frame counts as running until somebody waits for it
    double frameMs = 0;                   // set by the test: time of every frame
    std::vector<std::string> lastLabels;  // of the steps of the last frame
};

/** Code::Version or Code::CorruptData when the embedded shader pack does not fit, as for other backends. record: may be null. */
Result<std::unique_ptr<Backend>> createNullBackend(std::shared_ptr<NullRecord> record, const NullOptions& options = {});

}  // namespace dpl
