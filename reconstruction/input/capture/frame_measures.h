// SPDX-License-Identifier: Apache-2.0
// What the ingest check measures on one frame. Private to reconstruction/input/capture.
#pragma once

#include "reconstruction/input/capture/scan_check.h"

namespace dpl {

struct FrameMeasures {
    FrameCheck check;
    ImageGrey8 mask;                  // empty when absent or unreadable
    std::vector<Keypoint> keypoints;  // empty when absent or unreadable
    double labelAgreement = -1;       // IoU of label > 0 with the mask; −1: unknown
};

/** For test frames the files are only decoded, to find unreadable ones; nothing else is measured or kept. */
FrameMeasures measureFrame(const Scan& scan, const ScanFrame& frame);

}  // namespace dpl
