// SPDX-License-Identifier: Apache-2.0
#include <chrono>

#include "reconstruction/distill/corrective_model.h"
#include "reconstruction/pipeline/preset.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/pipeline/trained_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr double kCheckpointSeconds = 30;  // a kill loses at most about this much training
constexpr uint32_t kProbeSteps = 60;

Result<CoOptimiseInput> trainingInput(const SubjectData& subject, std::vector<TrainFrame> frames) {
    CoOptimiseInput input;
    input.joints = subject.shaped.joints;
    input.mesh = subject.shaped.mesh;
    for (size_t v = 0; v < input.mesh.restPositions.size(); ++v) input.mesh.restPositions[v] += subject.surfaceOffsets[v];
    std::vector<Pose> moving;
    for (const TrainFrame& frame : frames)
        if (frame.kind == FrameKind::Dynamic) moving.push_back(frame.pose);
    DPL_TRY(input.correctives, correctiveModel(input.joints, input.mesh, moving));
    input.triangleLabel = voteTriangleLabels(input.joints, input.mesh, frames, subject.jobs);
    input.frames = std::move(frames);
    return input;
}

/** A time budget becomes a step count once: a probe at the preset's settings is timed and thrown away; the count is remembered beside the
 * checkpoint. */
Result<uint32_t> chooseSteps(const SubjectData& subject, const CoOptimiseInput& input, CoOptimiseSettings settings,
                             const std::filesystem::path& folder) {
    if (subject.options.steps > 0) return subject.options.steps;
    if (subject.options.timeBudgetMinutes <= 0) return settings.steps;
    const std::filesystem::path remembered = folder / "steps.txt";
    if (auto bytes = readFile(remembered, 64))
        return uint32_t(std::max(1L, std::strtol(std::string(bytes->begin(), bytes->end()).c_str(), nullptr, 10)));
    settings.fullResolutionOnly = true;  // the dearest steps: a budget is not overrun
    DPL_TRY(auto probe, CoOptimiser::create(input, settings, subject.jobs));
    const auto start = std::chrono::steady_clock::now();
    DPL_CHECK_OK(probe->run({}, nullptr, kProbeSteps));
    const double secondsPerStep = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / kProbeSteps;
    const uint32_t steps = uint32_t(std::clamp(subject.options.timeBudgetMinutes * 60 / secondsPerStep, 100.0, 1e6));
    DPL_CHECK_OK(writeFileAtomically(remembered, std::to_string(steps)));
    return steps;
}

Status train(const SubjectData& subject, StageContext& context) {
    context.progress.update(0, "reading pictures");
    DPL_TRY(auto frames, loadTrainFrames(subject, Split::Train));
    if (frames.empty()) return fail(Code::InvalidArgument, "no usable training frames");
    DPL_TRY(CoOptimiseInput input, trainingInput(subject, std::move(frames)));
    CoOptimiseSettings settings = presetOf(subject.options.preset).training;
    settings.seed = subject.options.seed;
    DPL_TRY(settings.steps, chooseSteps(subject, input, settings, context.folder));
    DPL_TRY(auto optimiser, CoOptimiser::create(std::move(input), settings, subject.jobs));
    const std::filesystem::path checkpoint = context.folder / "checkpoint";
    if (std::filesystem::exists(checkpoint)) {
        if (Status restored = optimiser->restore(checkpoint); restored)
            context.progress.note(formatText("continuing at step {}", optimiser->step()));
        else
            context.progress.note(formatText("starting over: {}", restored.error().message));
    }
    const auto report = [&](const CoOptimiseProgress& p) {
        char line[96];
        std::snprintf(line, sizeof line, "step %u of %u, %u splats, scale %.2f, %.1f dB", p.step, p.steps, p.splats, double(p.scale),
                      double(p.recent.psnr));
        context.progress.update(double(p.step) / p.steps, line);
    };
    auto saved = std::chrono::steady_clock::now();
    while (!optimiser->finished()) {
        const Status ran = optimiser->run(report, &context.progress.cancelFlag(), 100);
        const bool due = std::chrono::duration<double>(std::chrono::steady_clock::now() - saved).count() > kCheckpointSeconds;
        if (due || !ran) {
            DPL_CHECK_OK(optimiser->checkpoint(checkpoint));
            saved = std::chrono::steady_clock::now();
        }
        DPL_CHECK_OK(ran);
    }
    DPL_CHECK_OK(writeTrainedFile(optimiser->result(), context.folder / "trained.bin"));
    std::error_code ignored;
    std::filesystem::remove(checkpoint, ignored);
    return {};
}

}  // namespace

Status runCoOptimise(SubjectData& subject) {
    DPL_TRY(std::string training, trainingDataHash(subject));
    const nlohmann::json inputs = {{"training", training},
                                   {"body_fit", subject.chain.keyOf("body-fit")},
                                   {"surface", subject.chain.keyOf("surface")},
                                   {"preset", presetOf(subject.options.preset).name},
                                   {"steps", subject.options.steps},
                                   {"budget", subject.options.timeBudgetMinutes},
                                   {"seed", subject.options.seed}};
    auto folder = subject.chain.run("co-optimise", 4, inputs, [&](StageContext& context) { return train(subject, context); });
    if (!folder) return folder.error();
    subject.trainedFolder = *folder;
    return {};
}

}  // namespace dpl
