// SPDX-License-Identifier: Apache-2.0
// The list of a sample scan's pictures: cameras, poses and splits. Private to reconstruction/subject/sample.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/sample/scan_writer.h"
#include "reconstruction/subject/sample/subject.h"
#include "sdk/math/camera.h"

namespace dpl {

struct PlannedFrame {
    std::string name, closeupOf;
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    double timeS = 0;  // of dynamic frames
    Camerad camera;    // world +Y up
    TruthPose pose;
    std::vector<Vec3d> lag;           // of dynamic frames: per swing driver, metres
    std::vector<LockNode> lockNodes;  // of dynamic frames with hair that swings
    bool keepPosed = false;           // write its posed vertices to posed/
    bool keepFine = false;            // write its picture at 4 times the size to hires/
};

/** A static orbit at three heights, close-ups, and a dynamic sequence during which the camera circles the subject one and a half times. */
std::vector<PlannedFrame> planScan(const Subject& subject, const SampleScanOptions& options);

}  // namespace dpl
