// SPDX-License-Identifier: Apache-2.0
// The ingest check: is this scan good enough, and if not, what should be captured again?
#pragma once

#include <array>
#include <string>
#include <vector>

#include "reconstruction/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

enum class ScanVerdict : uint8_t { Pass, Usable, Refuse };

struct ScanFinding {
    bool refuses = false;             // false: a warning
    std::string topic;                // "blur", "exposure", "azimuth", "poses", "masks", "border", "files", "cameras", "keypoints"
    std::string sentence;             // what is wrong and what to do
    std::vector<std::string> frames;  // names, when it is about some of them
};

/** What was measured of one training frame. Held-out frames are only checked for being readable: nothing may depend on what they show. */
struct FrameCheck {
    std::string name;
    bool measured = false;
    bool usable = true;             // false: unreadable, blurred or without a person; later stages leave the frame out
    std::string error;              // why a file could not be read
    double sharpness = 0;           // variance of the Laplacian inside the mask, grey levels²
    double relativeSharpness = 1;   // over the median of the frames of its kind
    double blurIndex = 0;           // 0 (sharp) … 1: share of local contrast that survives a second blur; does not need other frames
    double brightness = 0;          // mean grey level inside the mask, 0 … 255
    double maskShare = -1;          // of the picture; −1: no mask
    double borderShare = 0;         // of the picture's edge that the mask touches (full-body frames)
    double keypointsOnPerson = -1;  // share of confident keypoints near the mask; −1: unknown
};

/** Range of an angle in the picture over the dynamic training frames, 5th to 95th percentile, degrees. */
struct JointCoverage {
    std::string name;  // "elbow_l" ...
    uint32_t frames = 0;
    double lowDeg = 0, highDeg = 0;
};

constexpr uint32_t kAzimuthBins = 24;

struct ScanCheck {
    ScanVerdict verdict = ScanVerdict::Pass;
    std::vector<ScanFinding> findings;
    std::vector<FrameCheck> frames;  // same order as the scan's
    std::array<uint32_t, kAzimuthBins>
        azimuth{};  // static full-body training frames per 15° about the subject; bin 0 starts at the front (+z) going to +x
    double largestGapDeg = 360;
    double medianBlurIndex = 0;
    double exposureSpreadStops = 0;   // 5th to 95th percentile of log2 brightness, static full-body frames
    double exposureJumpStops = 0;     // largest change between neighbouring static frames' running medians
    double silhouetteCoherence = -1;  // silhouettes.h; −1: fewer than four masks
    double keypointErrorPx = -1;      // median reprojection error of triangulated keypoints, static full-body frames; −1: unknown
    double keypointErrorShare = -1;   // the same over the subject's height in the picture
    std::vector<JointCoverage> joints;
};

/** Opens every file of the scan. Returns an error only when nothing could be examined; what is wrong with the scan is in the findings. */
Result<ScanCheck> checkScan(const Scan& scan, Jobs& jobs);

/** The verdict for people: a few lines, the last one PASS, USABLE or REFUSE with the number of warnings or the reasons. */
std::string describeScanCheck(const Scan& scan, const ScanCheck& check);

/** The same for machines: one JSON object. */
std::string scanCheckJson(const Scan& scan, const ScanCheck& check);

}  // namespace dpl
