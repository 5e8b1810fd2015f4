// SPDX-License-Identifier: Apache-2.0
// Which pictures a sample scan holds: cameras, poses and splits. Private to reconstruction/sample.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/sample/scan_writer.h"
#include "reconstruction/sample/subject.h"
#include "sdk/math/camera.h"

namespace dpl {

struct PlannedFrame {
    std::string name, kind, split, closeupOf;
    double timeS = 0;  // dynamic frames
    Camerad camera;    // world +Y up
    TruthPose pose;
    std::vector<Vec3d> lag;  // dynamic frames: of each swing driver
    bool keepPosed = false;  // its vertices go to posed/
    bool keepFine = false;   // its picture at ×4 goes to hires/
};

/** Static orbit at three heights, close-ups, and the dynamic sequence with one and a half turns of the camera. */
std::vector<PlannedFrame> planScan(const Subject& subject, const SampleScanOptions& options);

}  // namespace dpl
