// SPDX-License-Identifier: Apache-2.0
// A scan folder of the procedural subject, with its truth: docs/formats/scan.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"

namespace dpl {

struct SampleScanOptions {
    uint64_t seed = 1;
    uint32_t widthPx = 378, heightPx = 504;
    uint32_t fullFrames = 60, closeupFrames = 24, dynamicFrames = 90;
    double dynamicS = 18.75;  // length of the motion
    uint32_t samplesPerPixel = 6;
    double exposureSpread = 0;   // standard deviation of the frames' gains (0: constant exposure)
    double sensorNoise = 0.004;  // display-referred
    int jpegQuality = 92;

    /** Half the size and fewer frames, for tests. */
    static SampleScanOptions small(uint64_t seed = 1) {
        SampleScanOptions o;
        o.seed = seed;
        o.widthPx = 189, o.heightPx = 252;
        o.fullFrames = 24, o.closeupFrames = 8, o.dynamicFrames = 30;
        o.samplesPerPixel = 4;
        return o;
    }
};

/** Called from the calling thread's pool with a share in [0, 1]; return false to stop (Code::Cancelled). Calls do not overlap. */
using SampleProgress = std::function<bool(double share, const std::string& what)>;

/** Writes scan.json, truth.json, images/, masks/, labels/, keypoints/, geometry/ and posed/ into `folder`, which must not exist or be
 *  empty. All is written to a neighbour folder with a temporary name that is renamed at the end: nothing half-written stays behind.
 *  Same options, same bytes, for any thread count. InvalidArgument: sizes below 16 px, fewer than 4 full frames. Io: the path that failed.
 */
Status makeSampleScan(const std::filesystem::path& folder, const SampleScanOptions& options, Jobs& jobs,
                      const SampleProgress& progress = {});

}  // namespace dpl
