// SPDX-License-Identifier: Apache-2.0
// poses.json: the poses that a reconstruction found for the frames of its scan (docs/formats/poses.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"

namespace dpl {

struct FramePose {
    std::string name, kind, split;   // as in scan.json: kind static_full, static_closeup or dynamic; split train, validation or test
    Pose pose;                       // of training frames after training, of others after registration
    std::optional<Pose> fittedPose;  // of validation and held-out frames, after the test-time pose fit
};

struct PosesFile {
    std::vector<std::string> jointNames;
    double metresPerUnit = 0;  // of the scan's world, where its cameras are not in metres; 0: they are, or the file is older
    std::vector<FramePose> frames;
};

std::string posesToJson(const PosesFile& poses);

/** Reads at most 256 MiB. CorruptData: not a poses file, or numbers are missing or not finite; the message names file, frame and joint.
 *  Version: not version 1. */
Result<PosesFile> readPosesFile(const std::filesystem::path& path);

}  // namespace dpl
