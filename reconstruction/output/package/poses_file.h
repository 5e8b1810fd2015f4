// SPDX-License-Identifier: Apache-2.0
// poses.json: the poses that a reconstruction found for the frames of its scan (docs/formats/poses.md).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct FramePose {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    Pose pose;                       // of training frames after training, of others as training carried it (run/carried_pose.h)
    std::optional<Pose> fittedPose;  // of validation and held-out frames, after the test-time pose fit

    /** The fitted pose, or the other where there is none. */
    const Pose& bestPose() const { return fittedPose ? *fittedPose : pose; }
};

struct PosesFile {
    std::string scanHash, avatarHash;  // hashOfScan() of the scan, content hash of the avatar; empty in older files
    std::vector<std::string> jointNames;
    std::vector<Vec3f> restPositions;  // of the joints, metres; empty in older files
    double metresPerUnit = 0;          // of the scan's world, where its cameras are not in metres; 0: they are, or the file is older
    std::vector<FramePose> frames;

    /** FramePose::pose of all frames. */
    std::vector<Pose> poses() const;
};

std::string posesToJson(const PosesFile& poses);

/** Reads at most 256 MiB. CorruptData: not a poses file, or numbers are missing or not finite; the message names file, frame and joint.
 *  Version: not version 1. */
Result<PosesFile> readPosesFile(const std::filesystem::path& path);

/** Whether the poses are of this skeleton: the same number of joints, which rest at the same places. InvalidArgument names both files.
 * Packed and dressed avatars keep the skeleton of their reconstruction. */
Status checkSkeleton(const PosesFile& poses, const std::filesystem::path& posesPath, std::span<const JointData> joints,
                     const std::filesystem::path& avatarPath);

}  // namespace dpl
