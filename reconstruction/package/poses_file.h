// SPDX-License-Identifier: Apache-2.0
// poses.json: the poses that a reconstruction found for the frames of its scan, so that anyone can draw them and score the pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"

namespace dpl {

struct FramePose {
    std::string name, kind, split;   // of the scan's frame: kind "static_full" | "static_closeup" | "dynamic"; split "train" | "test"
    Pose pose;                       // as registered; for training frames as trained
    std::optional<Pose> fittedPose;  // test frames: after the test-time pose fit
};

struct PosesFile {
    std::vector<std::string> jointNames;
    std::vector<FramePose> frames;
};

std::string posesToJson(const PosesFile& poses);

/** Checks joint counts, names and finiteness; errors name the file, the frame and the joint. */
Result<PosesFile> readPosesFile(const std::filesystem::path& path);

}  // namespace dpl
