// pose-fit: everything frozen but the poses of held-out frames (technical reference §20). After packaging: it cannot reach the avatar.
#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/preset.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/pipeline/trained_file.h"
#include "reconstruction/splat/polish.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

using nlohmann::json;

const char* kindName(FrameKind kind) {
    return kind == FrameKind::Dynamic ? "dynamic" : kind == FrameKind::StaticCloseup ? "static_closeup" : "static_full";
}

/** Held-out data that this stage looks at. */
json heldOutInputs(const SubjectData& subject) {
    json out = json::array();
    for (const ScanFrame& frame : subject.scan.frames) {
        if (frame.split != Split::Test) continue;
        json entry = {frame.name};
        for (const std::filesystem::path* path : {&frame.imagePath, &frame.maskPath})
            if (!path->empty())
                if (auto hash = hashFile(*path)) entry.push_back(*hash);
        out.push_back(entry);
    }
    return out;
}

Status fitPoses(SubjectData& subject, StageContext& context) {
    DPL_TRY(auto bytes, readFile(subject.packageFolder / "avatar.glb"));
    DPL_TRY(AvatarData avatar, readAvatar(bytes));
    DPL_TRY(CoOptimiseResult trained, readTrainedFile(subject.trainedFolder / "trained.bin", subject.shaped.mesh.triangles.size(),
                                                      subject.shaped.mesh.restPositions.size(), subject.shaped.joints.size()));
    PosesFile poses;
    for (const JointData& joint : avatar.joints) poses.jointNames.push_back(joint.name);
    size_t testCount = 0, done = 0, trainIndex = 0;
    for (const ScanFrame& frame : subject.scan.frames) testCount += frame.split == Split::Test;
    for (size_t f = 0; f < subject.scan.frames.size(); ++f) {
        const ScanFrame& frame = subject.scan.frames[f];
        FramePose entry{frame.name, kindName(frame.kind), frame.split == Split::Test ? "test" : "train", subject.fit.poses[f], std::nullopt};
        if (frame.split == Split::Train) {
            if (subject.usable[f] && trainIndex < trained.poses.size()) entry.pose = trained.poses[trainIndex++];
        } else {
            if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
            auto loaded = loadTrainFrame(frame, subject.fit.poses[f]);
            if (loaded) {
                PoseFitSettings settings;
                settings.iterations = presetOf(subject.options.preset).poseFitSteps;
                if (auto fitted = fitPose(avatar, *loaded, settings, subject.jobs)) entry.fittedPose = fitted->pose;
            }
            context.progress.update(double(++done) / double(testCount), frame.name);
        }
        poses.frames.push_back(std::move(entry));
    }
    return writeFileAtomically(context.folder / "poses.json", posesToJson(poses));
}

}  // namespace

Status runPoseFit(SubjectData& subject) {
    const json inputs = {{"package", subject.chain.keyOf("package")}, {"body_fit", subject.chain.keyOf("body-fit")}, {"held_out", heldOutInputs(subject)}};
    auto folder = subject.chain.run("pose-fit", 1, inputs, [&](StageContext& context) { return fitPoses(subject, context); });
    if (!folder) return folder.error();
    subject.poseFitFolder = *folder;
    DPL_TRY(auto bytes, readFile(*folder / "poses.json"));
    return writeFileAtomically(subject.options.out / "poses.json", bytes);
}

}  // namespace dpl
