// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/profile_training.h"

#include "reconstruction/run/preset.h"
#include "reconstruction/run/training_device.h"
#include "reconstruction/subject/sample/sample_frames.h"
#include "reconstruction/training/correctives/corrective_model.h"
#include "sdk/avatar/stress_poses.h"

namespace dpl {
namespace {

constexpr uint32_t kStillFrames = 8, kMovingFrames = 4, kMotionPoses = 30;

Result<CoOptimiseInput> proceduralInput(const SampleScanOptions& scan, Jobs& jobs) {
    const Subject subject = makeSubject(scan.seed, jobs);
    CoOptimiseInput input;
    DPL_TRY(input.frames, sampleFrames(subject, scan, jobs));
    input.joints = subject.joints, input.mesh = subject.mesh, input.triangleLabel = triangleLabels(subject);
    DPL_TRY(input.correctives, correctiveModel(input.joints, input.mesh, sampleMotionPoses(subject, scan, kMotionPoses)));
    input.stress = stressPoses(input.joints);
    return input;
}

}  // namespace

Result<ProfiledTraining> profileTraining(const ReconstructOptions& options, uint32_t widthPx, uint32_t heightPx, const ProfiledSteps& steps,
                                         Progress& progress) {
    if (!options.scan.empty()) return profileTraining(options, steps, progress);
    Jobs jobs(options.threadCount);
    progress.beginStage("training steps");
    ShownTask task(progress);
    const TaskScope scope(&task);
    SampleScanOptions scan;
    scan.seed = options.seed, scan.widthPx = widthPx, scan.heightPx = heightPx;
    scan.fullFrames = kStillFrames, scan.closeupFrames = 0, scan.dynamicFrames = kMovingFrames, scan.samplesPerPixel = 1;
    DPL_TRY(CoOptimiseInput input, proceduralInput(scan, jobs));
    CoOptimiseSettings settings = settingsOf(options).training;
    settings.init.clothLabels = {kLabelTop, kLabelBottom}, settings.init.openLabels = {kLabelHair};
    DPL_TRY(const auto engine, engineOf(options.device, progress));
    DPL_TRY(const ProfiledTraining made, profileSteps(std::move(input), settings, steps, jobs, engine.get()));
    progress.endStage(formatText("{} of {}x{}", steps.steps, widthPx, heightPx));
    return made;
}

}  // namespace dpl
