// SPDX-License-Identifier: Apache-2.0
// The ingest check: whether a scan is good enough, and what to capture again if it is not.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

enum class ScanVerdict : uint8_t { Pass, Usable, Refuse };

struct ScanFinding {
    bool refuses = false;             // false: a warning
    std::string topic;                // "blur", "exposure", "azimuth", "poses", "masks", "border", "files", "cameras", "keypoints"
    std::string sentence;             // the problem and its remedy
    std::vector<std::string> frames;  // names of the frames concerned; empty: the whole scan
};

/** Measurements of one training frame. Test frames are only checked for readability, because no decision may depend on their content. */
struct FrameCheck {
    std::string name;
    bool measured = false;
    bool usable = true;             // false: unreadable, blurred or without a person; later stages leave the frame out
    std::string error;              // why a file could not be read
    double sharpness = 0;           // variance of the Laplacian inside the mask, grey levels²
    double relativeSharpness = 1;   // sharpness divided by the median of the frames of this kind
    double blurIndex = 0;           // 0 (sharp) … 1: share of local contrast that survives a blur; needs no other frame
    double brightness = 0;          // mean grey level inside the mask, 0 … 255
    double maskShare = -1;          // share of the picture; −1: no mask
    double borderShare = 0;         // share of the picture's edge that the mask touches (full-body frames)
    double keypointsOnPerson = -1;  // share of confident keypoints near the mask; −1: unknown
};

/** Range of a joint's angle, measured in the picture, over the dynamic training frames: 5th to 95th percentile. */
struct JointCoverage {
    std::string name;  // "elbow_l" ...
    uint32_t frames = 0;
    double lowDeg = 0, highDeg = 0;
};

constexpr uint32_t kAzimuthBins = 24;

struct ScanCheck {
    ScanVerdict verdict = ScanVerdict::Pass;
    std::vector<ScanFinding> findings;
    std::vector<FrameCheck> frames;                // same order as the scan's
    std::array<uint32_t, kAzimuthBins> azimuth{};  // static full-body training frames per 15° of azimuth; bin 0 starts at +Z, towards +X
    double largestGapDeg = 360;
    double medianBlurIndex = 0;
    double exposureSpreadStops = 0;   // 5th to 95th percentile of log2 brightness, static full-body frames
    double exposureJumpStops = 0;     // largest change of the running median between neighbouring static frames
    double silhouetteCoherence = -1;  // silhouettes.h; −1: fewer than four masks
    double keypointErrorPx = -1;      // median reprojection error of triangulated keypoints, static full-body frames; −1: unknown
    double keypointErrorShare = -1;   // keypointErrorPx divided by the subject's height in the picture
    uint32_t moments = 0;             // moments of dynamic frames that four cameras or more see at once
    double momentErrorPx = -1;        // median reprojection error of keypoints triangulated from frames of one moment; −1: no such moment
    double focalFactor = -1;  // focal_check.h: all focal lengths times this fit the keypoints best; −1: unknown, or exact as given
    std::vector<JointCoverage> joints;
};

/** Why checkScan() will refuse the scan for its list of frames alone: too few show the whole subject standing still. Empty: they suffice.
 */
std::string missingStillPart(const Scan& scan);

/** Opens every file of the scan. Problems of the scan become findings; an error means that nothing could be examined.
 *  Cancelled. */
Result<ScanCheck> checkScan(const Scan& scan, Jobs& jobs);

/** The verdict as a few lines of text: what to do about the scan, then measurements. The last line is PASS, USABLE or REFUSE with the
 * number of warnings or the reasons. */
std::string describeScanCheck(const Scan& scan, const ScanCheck& check);

/** The verdict as one JSON object. */
std::string scanCheckJson(const Scan& scan, const ScanCheck& check);

}  // namespace dpl
