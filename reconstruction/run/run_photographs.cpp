// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/run_photographs.h"

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/run_scan.h"
#include "sdk/format/avatar_file.h"

namespace dpl {

Result<std::vector<TrainFrame>> stillPhotographs(const std::filesystem::path& avatarPath, const std::filesystem::path& scan,
                                                 const std::filesystem::path& poses) {
    const std::filesystem::path posesPath = poses.empty() ? avatarPath.parent_path() / "poses.json" : poses;
    DPL_TRY(const auto bytes, readAvatarBytes(avatarPath));
    DPL_TRY(const AvatarData avatar, avatarOf(avatarPath, bytes, "photographs"));
    DPL_TRY(const AvatarInfo info, inspectAvatar(bytes));
    DPL_TRY(RunScan run, readRunScan(scan, posesPath));
    DPL_RETURN_IF_ERROR(checkSkeleton(run.poses, posesPath, avatar.joints, avatarPath));
    if (!run.poses.avatarHash.empty() && run.poses.avatarHash != info.contentHash)
        return fail(Code::InvalidArgument, "{} is not the avatar that {} is of; photographs go with the avatar.glb that the run wrote",
                    avatarPath.string(), posesPath.string());
    FrameTable table;
    table.scan = std::move(run.scan);
    table.usable.assign(table.rows(), true);
    const std::vector<Pose> found = run.poses.poses();
    std::vector<TrainFrame> out;
    for (size_t row = 0; row < table.rows(); ++row)
        if (const ScanFrame& frame = table.scan.frames[row];
            table.trains(row) && frame.kind != FrameKind::Dynamic && !frame.maskPath.empty())
            out.push_back(table.frame(row, run.cameras[row], found[row]));
    if (out.empty()) return fail(Code::NotFound, "{} has no still frame with a mask that trained the avatar", scan.string());
    return out;
}

}  // namespace dpl
