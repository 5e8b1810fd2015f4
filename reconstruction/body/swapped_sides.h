// SPDX-License-Identifier: Apache-2.0
// Finds moving frames in which a detector took the left side of the body for the right one.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/capture/scan.h"

namespace dpl {

/** One moving frame. */
struct SidedFrame {
    double timeS = 0;
    double diagonalPx = 1;  // of the picture
    std::span<const Keypoint> keypoints;
    bool known = false;  // its sides are right
};

/** `frames`: in time. For each frame whether its left and right keypoints are swapped against the sequence. Minimises the motion of the
 *  sided keypoints from frame to frame plus a constant for each swapped frame; of two opposite answers the one with fewer swapped frames
 *  wins. A gap of more than a second joins nothing. Names end in _l and _r. */
std::vector<bool> swappedSides(std::span<const SidedFrame> frames, std::span<const std::string> names);

/** The same for the frames of a scan, false for still frames. Training frames are judged without the held-out ones. */
std::vector<bool> swappedSides(const Scan& scan, std::span<const std::vector<Keypoint>> keypoints);

/** The keypoints with left and right exchanged. */
std::vector<Keypoint> withSidesSwapped(std::span<const Keypoint> keypoints, std::span<const std::string> names);

}  // namespace dpl
