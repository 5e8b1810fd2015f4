// SPDX-License-Identifier: Apache-2.0
// The stage pose-fit: fits the poses of held-out frames and changes nothing else (docs/reference/registration.md). It runs after package,
// so it cannot affect the avatar.
#include "reconstruction/pipeline/stage_keys.h"
#include "reconstruction/pipeline/stages.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

using nlohmann::json;

const char* kindName(FrameKind kind) {
    return kind == FrameKind::Dynamic ? "dynamic" : kind == FrameKind::StaticCloseup ? "static_closeup" : "static_full";
}

/** The held-out data that this stage reads. */
json heldOutInputs(const IngestedScan& ingested) {
    json out = json::array();
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f)
        if (ingested.scan.frames[f].split == Split::Test)
            out.push_back({ingested.scan.frames[f].name, ingested.hashes[f].image, ingested.hashes[f].mask});
    return out;
}

/** The trained pose of each frame of the scan; null for frames that were not trained on. */
std::vector<const Pose*> trainedPoses(const IngestedScan& ingested, const CoOptimiseResult& trained) {
    std::vector<const Pose*> byFrame(ingested.scan.frames.size(), nullptr);
    size_t next = 0;
    for (size_t f = 0; f < byFrame.size() && next < trained.poses.size(); ++f)
        if (isTrainingFrame(ingested, f)) byFrame[f] = &trained.poses[next++];
    return byFrame;
}

Quatf shorterSlerp(const Quatf& a, const Quatf& b, float t) {
    return glm::normalize(glm::slerp(a, glm::dot(a, b) < 0 ? -b : b, t));
}

/** The registered pose of a held-out frame; it does not use the frame's picture. Training moves poses and surface together, so the body
 *  fit's pose alone would not match the trained surface.
 *  Still frames: interpolated between the trained poses of the neighbours in capture order. Moving frames: the body fit's pose (from the
 *  frame's own keypoints), corrected by the change of the neighbours' poses in training. `untrained`: all poses before training. */
Pose registeredPose(const Scan& scan, const std::vector<Pose>& untrained, const std::vector<const Pose*>& trained, size_t f) {
    const ScanFrame& frame = scan.frames[f];
    const Pose& fitted = untrained[f];
    const auto neighbour = [&](int step) -> long {
        for (long k = long(f) + step; k >= 0 && k < long(trained.size()); k += step)
            if (trained[size_t(k)] && scan.frames[size_t(k)].kind == frame.kind) return k;
        return -1;
    };
    long before = neighbour(-1), after = neighbour(+1);
    if (before < 0) before = after;
    if (after < 0) after = before;
    if (before < 0) return fitted;
    const float t = after == before ? 0.0f : float(long(f) - before) / float(after - before);
    const Pose &a = *trained[size_t(before)], &b = *trained[size_t(after)];
    Pose pose = fitted;
    if (frame.kind != FrameKind::Dynamic) {
        for (size_t j = 0; j < pose.localRotations.size(); ++j)
            pose.localRotations[j] = shorterSlerp(a.localRotations[j], b.localRotations[j], t);
        pose.rootTranslation = glm::mix(a.rootTranslation, b.rootTranslation, t);
        return pose;
    }
    const Pose &fitA = untrained[size_t(before)], &fitB = untrained[size_t(after)];
    for (size_t j = 0; j < pose.localRotations.size(); ++j) {
        const Quatf changeA = a.localRotations[j] * glm::inverse(fitA.localRotations[j]),
                    changeB = b.localRotations[j] * glm::inverse(fitB.localRotations[j]);
        pose.localRotations[j] = glm::normalize(shorterSlerp(changeA, changeB, t) * fitted.localRotations[j]);
    }
    pose.rootTranslation += glm::mix(a.rootTranslation - fitA.rootTranslation, b.rootTranslation - fitB.rootTranslation, t);
    return pose;
}

}  // namespace

Result<FoundPoses> runPoseFit(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                              const Training& training, const Package& package, Pictures& pictures, const RunSettings& settings) {
    const Scan& scan = ingested.scan;
    const auto fitPoses = [&](StageContext& context) -> Status {
        DPL_TRY(AvatarData avatar, readAvatar(package.bytes));
        PosesFile poses;
        for (const JointData& joint : avatar.joints) poses.jointNames.push_back(joint.name);
        const std::vector<const Pose*> trained = trainedPoses(ingested, training.result);
        size_t testCount = 0, done = 0;
        for (const ScanFrame& frame : scan.frames) testCount += frame.split == Split::Test;
        for (size_t f = 0; f < scan.frames.size(); ++f) {
            const ScanFrame& frame = scan.frames[f];
            FramePose entry{frame.name, kindName(frame.kind), frame.split == Split::Test ? "test" : "train", surface.poses[f],
                            std::nullopt};
            if (frame.split == Split::Train) {
                if (trained[f]) entry.pose = *trained[f];
            } else {
                if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
                entry.pose = registeredPose(scan, surface.poses, trained, f);
                // A held-out frame whose picture cannot be used keeps its registered pose.
                if (auto shown = frameAt(ingested, f, body.cameras[f], entry.pose, pictures))
                    if (auto fitted = fitPose(avatar, *shown, settings.poseFit, run.jobs)) entry.fittedPose = fitted->pose;
                context.progress.update(double(++done) / double(testCount), frame.name);
            }
            poses.frames.push_back(std::move(entry));
        }
        return writeFileAtomically(context.folder / "poses.json", posesToJson(poses));
    };
    const json inputs = {{"package", package.key},
                         {"trained", training.key},
                         {"surface", surface.key},
                         {"held_out", heldOutInputs(ingested)},
                         {"settings", fieldsJson(settings.poseFit)}};
    DPL_TRY(const StageOutput stage, run.chain.run("pose-fit", 2, inputs, fitPoses));
    const std::filesystem::path file = stage.folder / "poses.json";
    DPL_TRY(PosesFile poses, readPosesFile(file));
    return FoundPoses{file, std::move(poses), stage.key};
}

}  // namespace dpl
