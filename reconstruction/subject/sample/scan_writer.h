// SPDX-License-Identifier: Apache-2.0
// Writes a scan folder of the procedural subject with its truth (docs/formats/scan.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "reconstruction/subject/sample/hair_locks.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"

namespace dpl {

struct SampleScanOptions {
    uint64_t seed = 1;
    bool skirt = false;               // a wide skirt to the knee in place of shorts
    bool fingers = false;             // hands that move (hand_motion.h), with keypoints; of each hand one close-up is held out
    Hairstyle hair = Hairstyle::Cap;  // locks in place of the close cap; long ones swing, and the head shakes in the moving part
    bool chart = false;               // a test chart on the shirt; its middle close-up is held out, and truth.json tells where its bars are
    bool posters = false;             // a room with posters and a patterned floor, in which cameras can be found; the person is the same
    uint32_t widthPx = 378, heightPx = 504;
    uint32_t fullFrames = 60, closeupFrames = 24, dynamicFrames = 90;
    double dynamicS = 18.75;  // duration of the motion
    uint32_t samplesPerPixel = 6;
    double exposureSpread = 0;   // standard deviation of ln(gain) over frames; 0: constant exposure
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

/** Writes scan.json, truth.json, images/, masks/, labels/, keypoints/, geometry/, posed/ and hires/ into `folder`, which must be new or
 *  empty. Files are written to a neighbouring folder FOLDER.partial, which is renamed at the end or removed after an error. The same
 * options give the same bytes for any thread count. InvalidArgument: options out of range (the message states the range) or a folder in
 * use. Io: names the path that failed. Cancelled. */
Status makeSampleScan(const std::filesystem::path& folder, const SampleScanOptions& options, Jobs& jobs);

}  // namespace dpl
