// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_pose_fit.h"

#include "reconstruction/run/carried_pose.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_package.h"
#include "reconstruction/run/stage_register.h"
#include "reconstruction/training/trainer/pose_fitter.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

using nlohmann::json;

/** The data of validation and held-out frames that this stage reads. */
json judgedInputs(const FrameTable& table) {
    json out = json::array();
    for (size_t row = 0; row < table.rows(); ++row)
        if (table.scan.frames[row].split != Split::Train)
            out.push_back({table.scan.frames[row].name, table.hashes[row].image, table.hashes[row].mask});
    return out;
}

}  // namespace

Status StageOf<FoundPoses>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    DPL_TRY([[maybe_unused]] const FittedBody* body, in.part<FittedBody>());
    DPL_TRY(const SettingsAfterTraining* after, in.part<SettingsAfterTraining>());
    in.value("scan", table->scanHash);
    in.value("untrained", judgedInputs(*table));
    in.value("settings", fieldsJson(after->settings.poseFit));
    DPL_RETURN_IF_ERROR(in.use<RegisteredPoses>());
    DPL_RETURN_IF_ERROR(in.use<Training>());
    return in.use<Package>();
}

Status StageOf<FoundPoses>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const SettingsAfterTraining* after, in.of<SettingsAfterTraining>());
    DPL_TRY(const RegisteredPoses* registered, in.of<RegisteredPoses>());
    DPL_TRY(const Training* training, in.of<Training>());
    DPL_TRY(const Package* package, in.of<Package>());
    const Scan& scan = table->scan;
    DPL_TRY(AvatarData avatar, readAvatar(package->bytes));
    PosesFile poses;
    poses.scanHash = table->scanHash;
    DPL_TRY(const AvatarInfo info, inspectAvatar(package->bytes));
    poses.avatarHash = info.contentHash;
    for (const JointData& joint : avatar.joints) poses.jointNames.push_back(joint.name), poses.restPositions.push_back(joint.restPosition);
    if (!scan.metricWorld) poses.metresPerUnit = body->fit.metresPerUnit;
    const std::vector<Pose> found =
        posesAfterTraining(*table, registered->poses.poses, training->result, avatar.correctives.motion, HeldOut::Known);
    std::vector<size_t> rows;  // that are judged
    std::vector<TrainFrame> judged;
    for (size_t row = 0; row < table->rows(); ++row) {
        const ScanFrame& frame = scan.frames[row];
        poses.frames.push_back({frame.name, frame.kind, frame.split, found[row], std::nullopt});
        if (frame.split == Split::Train) continue;
        rows.push_back(row);
        judged.push_back(table->frame(row, metric->cameras[row], found[row]));
        judged.back().precision = registered->precisions[row];
    }
    DPL_TRY(const auto fits, PoseFitter(avatar, in.jobs()).fitAll(judged, after->settings.poseFit, in.jobs()));
    for (size_t i = 0; i < rows.size(); ++i)  // a frame whose picture cannot be used keeps its carried pose
        if (fits[i]) poses.frames[rows[i]].fittedPose = fits[i]->pose;
    return writeFileAtomically(context.folder / "poses.json", posesToJson(poses));
}

Result<FoundPoses> StageOf<FoundPoses>::read(StageInputs&, const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "poses.json";
    DPL_TRY(PosesFile poses, readPosesFile(file));
    return FoundPoses{file, std::move(poses)};
}

}  // namespace dpl
