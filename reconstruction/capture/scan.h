// SPDX-License-Identifier: Apache-2.0
// A scan folder in memory: frames, cameras, splits and observations. The world is metric, right-handed, +Y up, the subject faces +Z.
// Files are z-up and face −y; the readers turn every point by (x, z, −y).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reconstruction/cameras/camera_check.h"
#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

enum class FrameKind : uint8_t { StaticFull, StaticCloseup, Dynamic };
enum class Split : uint8_t { Train, Test };

struct ScanLabel {
    std::string name;  // "background", "body", "top", "bottom", "hair", "shoes"
    uint8_t value = 0;
};

struct ScanFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    std::filesystem::path imagePath, maskPath, labelsPath, keypointsPath;  // absolute; empty when absent
    Camerad camera;
    double timeS = 0;  // dynamic frames
    std::string closeupOf;
    LensDistortion lens;  // of the files on disk; readFrame…() and readKeypoints() return undistorted data that fit `camera`
};

/** Detected 2D keypoints of one frame, in the order of Scan::keypointNames. */
struct Keypoint {
    Vec2d px{0};
    double confidence = 0;  // 0: missing
};

enum class ScanSource : uint8_t { Folder, Nerfstudio, Colmap };

struct Scan {
    std::filesystem::path root;
    std::string name;
    ScanSource source = ScanSource::Folder;
    bool metricWorld = true;  // false (COLMAP): scale, origin and up are arbitrary; the body fit finds them
    bool splitStated = true;  // false: the source states no split; the reader held out one static full-body frame in ten
    std::vector<ScanLabel> labels;
    std::vector<std::string> keypointNames;
    std::vector<ScanFrame> frames;
};

/** Reads scan.json (docs/formats/scan.md), a nerfstudio transforms.json or a COLMAP sparse model, whichever `root` holds.
 *  Checks every path, number and size; truth files are never opened. Errors name the file and the remedy. */
Result<Scan> readScan(const std::filesystem::path& root);

/** Keypoints of one frame, from "detections" (older scans: "xy_noisy") of its file and never from "xy", the truth of synthetic scans.
 *  Empty when the frame has none. */
Result<std::vector<Keypoint>> readKeypoints(const Scan& scan, const ScanFrame& frame);

/** 8-bit RGB, row-major. */
struct ImageRgb8 {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint8_t> pixels;
};
struct ImageGrey8 {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint8_t> pixels;
};

/** Decodes and checks against the camera's size. */
Result<ImageRgb8> readFrameImage(const ScanFrame& frame);
Result<ImageGrey8> readFrameMask(const ScanFrame& frame);    // 0 … 255 (soft mattes are kept)
Result<ImageGrey8> readFrameLabels(const ScanFrame& frame);  // label values

}  // namespace dpl
