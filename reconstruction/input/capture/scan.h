// SPDX-License-Identifier: Apache-2.0
// A scan folder in memory: frames, cameras, splits and paths of observations. The world is right-handed, +Y up, in metres (see
// metricWorld); the subject faces +Z. scan.json is z-up with the subject facing −y; its reader maps every point to (x, z, −y).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/input/cameras/camera_check.h"
#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

enum class FrameKind : uint8_t { StaticFull, StaticCloseup, Dynamic };
enum class Split : uint8_t { Train, Validation, Test };  // in the order in which they are posed; files state train or test (validation.h)

/** The names in scan.json and poses.json: static_full, static_closeup, dynamic; train, validation, test. */
const char* frameKindName(FrameKind kind);
const char* splitName(Split split);
std::optional<FrameKind> frameKindNamed(std::string_view name);
std::optional<Split> splitNamed(std::string_view name);

/** The kind in reports: "static", "close-up" or "dynamic". */
const char* shortKindName(FrameKind kind);

struct ScanLabel {
    std::string name;  // "background", "body", "top", "bottom", "hair", "shoes"
    uint8_t value = 0;
};

struct ScanFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    std::filesystem::path imagePath, maskPath, labelsPath, keypointsPath;  // absolute; empty when absent
    bool maskFound = false;  // by our networks, which place its edge to a few pixels; false: by whoever made the scan
    Camerad camera;
    double timeS = 0;  // dynamic frames only
    std::string closeupOf;
    LensDistortion lens;  // of the files; readFrame…() and readKeypoints() undistort, so that their data match `camera`
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
    bool camerasKnown = true;   // false: frames have only a picture size; reconstruction/input/cameras/solve_cameras.h finds the rest
    double focalGuessPx = 0;    // where cameras are not known: a guess, from EXIF for example; 0: none
    bool metricWorld = true;    // false (COLMAP): arbitrary scale, origin and up; the body fit finds them
    bool unitStated = true;     // false: metricWorld is false only because the file says nothing; the body fit judges by the person's size
    std::string assumed;        // sentences about what the file does not state or states otherwise; empty: there is no such thing
    bool splitStated = true;    // false: the reader chose every tenth static full-body frame for test
    std::string protocol;       // "neuman": scores are also given by that published protocol (docs/reference/neuman.md); empty: none
    double subjectHeightM = 0;  // without shoes, as the user stated it; 0: unknown
    std::vector<ScanLabel> labels;
    std::vector<std::string> keypointNames;
    bool keypointsFound = false;  // by our networks, whose errors depend on the view; false: by whoever made the scan
    std::vector<ScanFrame> frames;
};

/** Whether a scan without cameras is an answer. */
enum class ScanCameras : uint8_t { Needed, MayLack };

/** Reads scan.json (docs/formats/scan.md), a nerfstudio transforms.json or a COLMAP sparse model, whichever `root` holds.
 *  Checks every path, number and size. Never opens truth files. Errors name the file and the remedy. */
Result<Scan> readScan(const std::filesystem::path& root, ScanCameras cameras = ScanCameras::Needed);

/** Keypoints of one frame, from the field "detections" (older scans: "xy_noisy"). The field "xy" holds the truth of synthetic scans and is
 *  never read. Empty when the frame has no keypoint file. */
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

/** Each decodes and undistorts one file. Its size must be that of the camera. */
Result<ImageRgb8> readFrameImage(const ScanFrame& frame);
Result<ImageGrey8> readFrameMask(const ScanFrame& frame);    // 0 … 255 (soft mattes are kept)
Result<ImageGrey8> readFrameLabels(const ScanFrame& frame);  // label values

}  // namespace dpl
