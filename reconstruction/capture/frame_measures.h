// SPDX-License-Identifier: Apache-2.0
// What the ingest check measures on one frame. Private to the capture room.
#pragma once

#include "reconstruction/capture/scan_check.h"

namespace dpl {

struct FrameMeasures {
    FrameCheck check;
    ImageGrey8 mask;                  // empty when absent or unreadable
    std::vector<Keypoint> keypoints;  // empty when absent or unreadable
    double labelAgreement = -1;       // IoU of label > 0 with the mask; −1: unknown
};

/** Held-out frames (split test): files are decoded for completeness and nothing of them is kept. */
FrameMeasures measureFrame(const Scan& scan, const ScanFrame& frame);

}  // namespace dpl
