// SPDX-License-Identifier: Apache-2.0
// Finds frames in which a detector took the left side of the body for the right one.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Which keypoints of a frame have left and right exchanged; bits. Detectors confuse the whole body (seen from behind) or only the legs. */
enum SwappedParts : uint8_t {
    kNoneSwapped = 0,
    kUpperSwapped = 1,  // eyes, ears, shoulders, arms
    kLowerSwapped = 2,  // hips, legs
    kAllSwapped = 3,
};

/** One moving frame. */
struct SidedFrame {
    double timeS = 0;
    double diagonalPx = 1;  // of the picture
    std::span<const Keypoint> keypoints;
    bool known = false;  // its sides are right
};

/** `frames`: in time. For each frame the SwappedParts against the sequence. Minimises the motion of the sided keypoints from frame to frame
 *  plus a constant for each swapped frame; of two opposite answers the one with fewer swapped frames wins. A gap of more than a second
 *  joins nothing. Names end in _l and _r. */
std::vector<uint8_t> swappedInMotion(std::span<const SidedFrame> frames, std::span<const std::string> names);

/** For each frame of the scan its SwappedParts. Still frames are held against points triangulated from all still training frames. If these
 *  points belong to a body whose feet and face point backwards, the sides are exchanged in the whole scan. Moving frames are judged by
 *  swappedInMotion(). Training frames are judged without the held-out ones. */
std::vector<uint8_t> swappedSides(const Scan& scan, std::span<const std::vector<Keypoint>> keypoints);

/** The keypoints with left and right exchanged in these parts. */
std::vector<Keypoint> withSidesSwapped(std::span<const Keypoint> keypoints, std::span<const std::string> names,
                                       uint8_t parts = kAllSwapped);

/** A sentence for the log, empty when nothing was swapped. */
std::string describeSwaps(const Scan& scan, std::span<const uint8_t> swapped);

}  // namespace dpl
