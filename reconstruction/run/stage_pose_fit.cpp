// SPDX-License-Identifier: Apache-2.0
// The stage pose-fit: fits the poses of frames that were not trained on and changes nothing else (docs/reference/registration.md). It runs
// after package, so it cannot affect the avatar.
#include "reconstruction/run/registered_pose.h"
#include "reconstruction/run/stage_keys.h"
#include "reconstruction/run/stages.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

using nlohmann::json;

/** The data of validation and held-out frames that this stage reads. */
json untrainedInputs(const IngestedScan& ingested) {
    json out = json::array();
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f)
        if (ingested.scan.frames[f].split != Split::Train)
            out.push_back({ingested.scan.frames[f].name, ingested.hashes[f].image, ingested.hashes[f].mask});
    return out;
}

}  // namespace

Result<FoundPoses> runPoseFit(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const RegisteredPoses& registered,
                              const Training& training, const Package& package, Pictures& pictures, const RunSettings& settings) {
    const Scan& scan = ingested.scan;
    const auto fitPoses = [&](StageContext& context) -> Status {
        DPL_TRY(AvatarData avatar, readAvatar(package.bytes));
        PosesFile poses;
        for (const JointData& joint : avatar.joints) poses.jointNames.push_back(joint.name);
        if (!scan.metricWorld) poses.metresPerUnit = body.fit.metresPerUnit;
        const std::vector<const Pose*> trained = trainedPoses(ingested, training.result);
        size_t untrained = 0, done = 0;
        for (const ScanFrame& frame : scan.frames) untrained += frame.split != Split::Train;
        for (size_t f = 0; f < scan.frames.size(); ++f) {
            const ScanFrame& frame = scan.frames[f];
            FramePose entry{frame.name, frameKindName(frame.kind), splitName(frame.split), registered.poses[f], std::nullopt};
            if (frame.split == Split::Train) {
                if (trained[f]) entry.pose = *trained[f];
            } else {
                if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
                entry.pose = registeredPose(scan, registered.poses, trained, f);
                // A frame whose picture cannot be used keeps its registered pose.
                if (auto shown = frameAt(ingested, f, body.cameras[f], entry.pose, pictures)) {
                    shown->precision = registered.precisions[f];
                    if (auto fitted = fitPose(avatar, *shown, settings.poseFit, run.jobs)) entry.fittedPose = fitted->pose;
                }
                context.progress.update(double(++done) / double(untrained), frame.name);
            }
            poses.frames.push_back(std::move(entry));
        }
        return writeFileAtomically(context.folder / "poses.json", posesToJson(poses));
    };
    const json inputs = {{"package", package.key},
                         {"trained", training.key},
                         {"register", registered.key},
                         {"untrained", untrainedInputs(ingested)},
                         {"settings", fieldsJson(settings.poseFit)}};
    DPL_TRY(const StageOutput stage, run.chain.run("pose-fit", 7, inputs, fitPoses));
    const std::filesystem::path file = stage.folder / "poses.json";
    DPL_TRY(PosesFile poses, readPosesFile(file));
    return FoundPoses{file, std::move(poses), stage.key};
}

}  // namespace dpl
