// SPDX-License-Identifier: Apache-2.0
// The text and binary files of a sample scan as bytes (docs/formats/scan.md). Inputs have +Y up; the files have z up. Private to
// reconstruction/subject/sample.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reconstruction/subject/sample/chart.h"
#include "reconstruction/subject/sample/scan_plan.h"

namespace dpl {

/** From the world (+Y up, facing +Z) to files (z up, facing −y). */
inline Vec3d fileFromWorld(const Vec3d& p) {
    return {p.x, -p.z, p.y};
}

struct SampleKeypoint {
    bool inFront = false;
    Vec2d px{0}, noisyPx{0};
    int visibility = 0;  // 0 outside the picture, 1 hidden, 2 visible
    double confidence = 0, sigmaPx = 0;
};

std::string scanJson(const Subject& subject, const std::vector<PlannedFrame>& frames, const SampleScanOptions& options);
/** What a frame shows where. `hands` is empty in a scan without moved fingers, `bars` but in held-out close-ups of a chart. */
struct TruePoints {
    std::vector<Vec3d> body, hands;  // keypoints, world, metres
    std::vector<BarsSeen> bars;
};
std::string truthJson(const Subject& subject, const std::vector<PlannedFrame>& frames, const std::vector<TruePoints>& points);
std::string keypointsJson(const Subject& subject, const PlannedFrame& frame, const std::vector<SampleKeypoint>& keypoints);
std::vector<uint8_t> templatePly(const Subject& subject);
std::vector<uint8_t> weightsBin(const Subject& subject);
std::vector<uint8_t> posedBin(const std::vector<Vec3d>& vertices);

}  // namespace dpl
