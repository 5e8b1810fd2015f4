// SPDX-License-Identifier: Apache-2.0
// cameras.json: what the stage `cameras` found. Cameras are in Doppel's world (+Y up); docs/formats/poses.md lists the fields.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/input/cameras/camera_verdict.h"
#include "reconstruction/input/capture/scan.h"

namespace dpl {

struct FoundCamera {
    std::string name;  // of the frame
    Camerad camera;
    double missPx = 0;  // median miss of its matches
    size_t matches = 0;
};

struct FoundCameras {
    std::vector<FoundCamera> cameras;    // of the frames that have one, in the scan's order
    LensDistortion lens;                 // of all; k1 and k2 only
    bool metric = false;                 // the world is in metres
    bool refused = false;                // too few
    std::vector<std::string> sentences;  // the verdict
    std::vector<CameraGap> gaps;         // what to film again
};

std::string camerasToJson(const FoundCameras& found);

/** The cameras of a scan, as withCameras() takes them. All frames have the first one's lens. */
FoundCameras camerasOf(const Scan& scan);

/** Checks every camera. Errors name the file. */
Result<FoundCameras> readCamerasFile(const std::filesystem::path& path);

/** The scan with these cameras. Frames without one are dropped. Every name must be that of a frame of the same size. */
Result<Scan> withCameras(Scan scan, const FoundCameras& found);

}  // namespace dpl
