// SPDX-License-Identifier: Apache-2.0
// pose-fit: everything frozen but the poses of held-out frames (docs/reference/registration.md). After packaging: it cannot reach the
// avatar.
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

/** Trained poses by frame of the scan; null where a frame was not trained on. */
std::vector<const Pose*> trainedPoses(const SubjectData& subject, const CoOptimiseResult& trained) {
    std::vector<const Pose*> byFrame(subject.scan.frames.size(), nullptr);
    size_t next = 0;
    for (size_t f = 0; f < byFrame.size() && next < trained.poses.size(); ++f)
        if (subject.scan.frames[f].split == Split::Train && subject.usable[f]) byFrame[f] = &trained.poses[next++];
    return byFrame;
}

Quatf shorterSlerp(const Quatf& a, const Quatf& b, float t) {
    return glm::normalize(glm::slerp(a, glm::dot(a, b) < 0 ? -b : b, t));
}

/** The registered pose of a held-out frame, from its trained neighbours in capture order and nothing of its own pictures. Training moves
 *  poses and surface together, so a pose of the body fit alone would sit in another gauge.
 *  Still frames: between the neighbours' trained poses (they hold one pose and sway slowly). Moving frames: the body fit's pose from the
 *  frame's own keypoints, turned by what training changed about the neighbours. */
Pose registeredPose(const SubjectData& subject, const std::vector<const Pose*>& trained, size_t f) {
    const ScanFrame& frame = subject.scan.frames[f];
    const Pose& fitted = subject.fit.poses[f];
    const auto neighbour = [&](int step) -> long {
        for (long k = long(f) + step; k >= 0 && k < long(trained.size()); k += step)
            if (trained[size_t(k)] && subject.scan.frames[size_t(k)].kind == frame.kind) return k;
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
    const Pose &fitA = subject.fit.poses[size_t(before)], &fitB = subject.fit.poses[size_t(after)];
    for (size_t j = 0; j < pose.localRotations.size(); ++j) {
        const Quatf changeA = a.localRotations[j] * glm::inverse(fitA.localRotations[j]),
                    changeB = b.localRotations[j] * glm::inverse(fitB.localRotations[j]);
        pose.localRotations[j] = glm::normalize(shorterSlerp(changeA, changeB, t) * fitted.localRotations[j]);
    }
    pose.rootTranslation += glm::mix(a.rootTranslation - fitA.rootTranslation, b.rootTranslation - fitB.rootTranslation, t);
    return pose;
}

Status fitPoses(SubjectData& subject, StageContext& context) {
    DPL_TRY(auto bytes, readFile(subject.packageFolder / "avatar.glb"));
    DPL_TRY(AvatarData avatar, readAvatar(bytes));
    DPL_TRY(CoOptimiseResult trained, readTrainedFile(subject.trainedFolder / "trained.bin", subject.shaped.mesh.triangles.size(),
                                                      subject.shaped.mesh.restPositions.size(), subject.shaped.joints.size()));
    PosesFile poses;
    for (const JointData& joint : avatar.joints) poses.jointNames.push_back(joint.name);
    const std::vector<const Pose*> byFrame = trainedPoses(subject, trained);
    size_t testCount = 0, done = 0;
    for (const ScanFrame& frame : subject.scan.frames) testCount += frame.split == Split::Test;
    for (size_t f = 0; f < subject.scan.frames.size(); ++f) {
        const ScanFrame& frame = subject.scan.frames[f];
        FramePose entry{frame.name, kindName(frame.kind), frame.split == Split::Test ? "test" : "train", subject.fit.poses[f],
                        std::nullopt};
        if (frame.split == Split::Train) {
            if (byFrame[f]) entry.pose = *byFrame[f];
        } else {
            if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
            entry.pose = registeredPose(subject, byFrame, f);
            auto loaded = loadTrainFrame(frame, entry.pose);
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
    const json inputs = {
        {"package", subject.chain.keyOf("package")}, {"body_fit", subject.chain.keyOf("body-fit")}, {"held_out", heldOutInputs(subject)}};
    auto folder = subject.chain.run("pose-fit", 2, inputs, [&](StageContext& context) { return fitPoses(subject, context); });
    if (!folder) return folder.error();
    subject.poseFitFolder = *folder;
    DPL_TRY(auto bytes, readFile(*folder / "poses.json"));
    return writeFileAtomically(subject.options.out / "poses.json", bytes);
}

}  // namespace dpl
