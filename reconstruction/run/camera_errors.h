// SPDX-License-Identifier: Apache-2.0
// How far the cameras of a scan are from the true ones (docs/reference/cameras.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Errors of the frames of one kind, after one similarity that aligns the full-body still frames of training for all kinds. */
struct CameraErrorRow {
    std::optional<FrameKind> kind;  // of training frames; none: all held-out frames
    size_t frames = 0, missing = 0;
    double eyeMmMedian = 0, eyeMmP90 = 0, eyeMmWorst = 0;
    double turnDegMedian = 0, turnDegP90 = 0, turnDegWorst = 0;
    double pxMedian = 0, pxP90 = 0;  // on a person of 1.75 m who stands at the origin
};

struct CameraErrors {
    double focalPx = 0, trueFocalPx = 0;  // of the first frame that both have
    double scale = 1;                     // metres per unit of the scan
    double tiltDeg = 0;                   // between the scan's up and the true one
    std::vector<CameraErrorRow> rows;
};

/** Compares the cameras of frames with equal names. `truth` must be metric. NotFound when too few frames are in both. */
Result<CameraErrors> compareCameras(const Scan& scan, const Scan& truth);

/** A table for the terminal. */
std::string describeCameraErrors(const CameraErrors& errors);

}  // namespace dpl
