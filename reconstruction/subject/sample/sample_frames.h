// SPDX-License-Identifier: Apache-2.0
// Pictures of the procedural subject in its true poses, in memory: training frames without a scan.
#pragma once

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/subject/sample/scan_writer.h"
#include "reconstruction/subject/sample/subject.h"

namespace dpl {

/** All frames of the scan that makeSampleScan() would write, with their true poses and without loss by JPEG. Same bytes for any thread
 *  count. Cancelled. */
Result<std::vector<TrainFrame>> sampleFrames(const Subject& subject, const SampleScanOptions& options, Jobs& jobs);

/** `count` poses of the subject's motion, evenly spaced in time. */
std::vector<Pose> sampleMotionPoses(const Subject& subject, const SampleScanOptions& options, uint32_t count);

/** The label of every triangle. */
std::vector<uint8_t> triangleLabels(const Subject& subject);

}  // namespace dpl
