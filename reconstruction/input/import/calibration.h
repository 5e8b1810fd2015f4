// SPDX-License-Identifier: Apache-2.0
// Calibrations of fixed, synchronised video cameras.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/input/cameras/camera_check.h"

namespace dpl {

struct CalibratedCamera {
    std::string name;
    Camerad camera;  // metres, world +Y up
    LensDistortion lens;
};

/** Qualisys camera calibration (.qca.txt), an XML file. */
Result<std::vector<CalibratedCamera>> parseQualisys(std::string_view text, const std::string& where);
/** Calibration of Pose2Sim (.toml). */
Result<std::vector<CalibratedCamera>> parsePose2sim(std::string_view text, const std::string& where);

/** Reads either, by the file's extension. At most 1 MiB and 256 cameras. Errors name the file, the camera and the remedy. */
Result<std::vector<CalibratedCamera>> readCalibration(const std::filesystem::path& file);

}  // namespace dpl
