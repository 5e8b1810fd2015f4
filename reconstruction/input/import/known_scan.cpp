// SPDX-License-Identifier: Apache-2.0
// Captures whose readers live in reconstruction/input/capture: nerfstudio (docs.nerf.studio, "Data conventions"), NeRFCapture, which writes
// the same with intrinsics for each frame, COLMAP (colmap.github.io, "Output Format"), and NeRF-synthetic.
//
// NeRF-synthetic follows the loader of github.com/bmild/nerf (load_blender.py): camera_angle_x in radians, file_path without an extension,
// OpenGL camera-to-world matrices in Blender's z-up world of arbitrary scale. The alpha channel is the mask.
#include "reconstruction/base/image_file.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/readers.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

CapturePicture pictureOf(const ScanFrame& frame) {
    return {frame.name, frame.kind, frame.split, frame.imagePath, frame.maskPath, frame.camera, frame.lens, frame.timeS, frame.closeupOf};
}

}  // namespace

std::string frameName(FrameKind kind, size_t index) {
    const char* const prefix = kind == FrameKind::StaticFull ? "full" : kind == FrameKind::StaticCloseup ? "close" : "dyn";
    std::string digits = std::to_string(index);
    if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
    return formatText("{}_{}", prefix, digits);
}

Result<Capture> readKnownScan(const fs::path& root) {
    DPL_TRY(const Scan scan, readScan(root));
    Capture capture;
    capture.what = scan.source == ScanSource::Colmap ? "COLMAP model" : "nerfstudio or NeRFCapture folder";
    capture.metricWorld = scan.metricWorld, capture.unitStated = scan.unitStated;
    capture.splitStated = scan.splitStated;
    if (!scan.assumed.empty()) capture.notes.push_back(scan.assumed);
    for (const ScanFrame& frame : scan.frames) capture.pictures.push_back(pictureOf(frame));
    return capture;
}

Result<Capture> readNerfSynthetic(const fs::path& root) {
    Capture capture;
    capture.what = "NeRF-synthetic folder";
    std::error_code ignored;
    for (const auto& [name, split] :
         {std::pair{"transforms_train.json", Split::Train}, {"transforms_val.json", Split::Test}, {"transforms_test.json", Split::Test}}) {
        if (split == Split::Test && !fs::exists(root / name, ignored)) continue;
        DPL_TRY(const Scan part, readNerfstudio(root / name, 'z'));
        if (!part.assumed.empty()) capture.notes.push_back(part.assumed);
        capture.metricWorld &= part.metricWorld, capture.unitStated &= part.unitStated;
        for (const ScanFrame& frame : part.frames) {
            CapturePicture picture = pictureOf(frame);
            picture.split = split;
            capture.splitStated |= split == Split::Test;
            capture.pictures.push_back(std::move(picture));
        }
    }
    return capture;
}

}  // namespace dpl
