// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <optional>

#include "reconstruction/run/stage_keys.h"
#include "reconstruction/run/stages.h"
#include "reconstruction/run/trained_file.h"
#include "reconstruction/subject/garments/stress_poses.h"
#include "reconstruction/training/correctives/corrective_model.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint32_t kProbeSteps = 60;

Result<CoOptimiseInput> trainingInput(const FittedBody& body, const DressedBody& dressed, std::vector<TrainFrame> frames) {
    CoOptimiseInput input;
    input.joints = body.shaped.joints;
    input.mesh = dressed.clothed.mesh;
    input.triangleLabel = dressed.clothed.triangleLabel;
    DPL_TRY(input.correctives, correctiveModel(input.joints, input.mesh, movingPoses(frames)));
    input.frames = std::move(frames);
    input.stress = stressPoses(input.joints);
    return input;
}

constexpr const char *kStepsFile = "steps.txt", *kCheckpointFile = "checkpoint", *kTrainedFile = "trained.bin";

/** The number of steps that a probe found for this run. None before it. */
std::optional<uint32_t> probedSteps(const std::filesystem::path& folder) {
    const auto bytes = readFile(folder / kStepsFile, 64);
    if (!bytes) return std::nullopt;
    return uint32_t(std::max(1L, std::strtol(std::string(bytes->begin(), bytes->end()).c_str(), nullptr, 10)));
}

/** The number of steps that fits into the time budget, by timing a short probe run of the slowest steps. The number is stored beside the
 *  checkpoint, so that a continued run uses the same one. */
Result<uint32_t> stepsInBudget(const CoOptimiseInput& input, const RunSettings& settings, Jobs& jobs, const StageContext& context) {
    if (const auto steps = probedSteps(context.folder)) return *steps;
    DPL_TRY(auto probe, CoOptimiser::create(input, slowestSteps(settings.training), jobs));
    const auto start = std::chrono::steady_clock::now();
    DPL_CHECK_OK(probe->run({}, &context.progress.cancelFlag(), kProbeSteps));
    const double secondsPerStep = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / kProbeSteps;
    const uint32_t steps = uint32_t(std::clamp(settings.timeBudgetMinutes * 60 / secondsPerStep, 100.0, 1e6));
    DPL_CHECK_OK(writeFileAtomically(context.folder / kStepsFile, std::to_string(steps)));
    return steps;
}

Status train(CoOptimiseInput input, const RunSettings& settings, Jobs& jobs, StageContext& context) {
    CoOptimiseSettings training = settings.training;
    if (settings.timeBudgetMinutes > 0) {
        DPL_TRY(training.steps, stepsInBudget(input, settings, jobs, context));
    }
    DPL_TRY(auto optimiser, CoOptimiser::create(std::move(input), training, jobs));
    const std::filesystem::path checkpoint = context.folder / kCheckpointFile;
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
        const bool due = std::chrono::duration<double>(std::chrono::steady_clock::now() - saved).count() > settings.checkpointS;
        if (due || !ran) {
            DPL_CHECK_OK(optimiser->checkpoint(checkpoint));
            saved = std::chrono::steady_clock::now();
        }
        DPL_CHECK_OK(ran);
    }
    return writeTrainedFile(optimiser->result(), context.folder / kTrainedFile);
}

}  // namespace

Result<Training> runCoOptimise(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const DressedBody& dressed,
                               const RegisteredPoses& registered, Pictures& pictures, const RunSettings& settings) {
    const nlohmann::json inputs = {{"training", ingested.trainingHash},
                                   {"body_fit", body.key},
                                   {"garments", dressed.key},
                                   {"register", registered.key},
                                   {"settings", trainingInputs(settings)}};
    const MeshData& mesh = dressed.clothed.mesh;
    const auto readTrained = [&](const std::filesystem::path& folder) {
        return readTrainedFile(folder / kTrainedFile, mesh.triangles.size(), mesh.restPositions.size(), body.shaped.joints.size());
    };
    DPL_TRY(const StageOutput stage, run.chain.run("co-optimise", 17, inputs, [&](StageContext& context) -> Status {
        const auto dropCheckpoint = [&]() -> Status {
            std::error_code ignored;
            std::filesystem::remove(context.folder / kCheckpointFile, ignored);
            return {};
        };
        if (readTrained(context.folder)) return dropCheckpoint();  // a run that was killed after its last file
        context.progress.update(0, "reading pictures");
        DPL_TRY(FrameSet set, framesOf(ingested, Split::Train, body.cameras, registered.poses, pictures));
        setPrecisions(set, registered.precisions);
        if (set.frames.empty()) return fail(Code::InvalidArgument, "no usable training frames");
        DPL_TRY(CoOptimiseInput input, trainingInput(body, dressed, std::move(set.frames)));
        DPL_CHECK_OK(train(std::move(input), settings, run.jobs, context));
        return dropCheckpoint();
    }));
    DPL_TRY(CoOptimiseResult result, readTrained(stage.folder));
    if (!(settings.timeBudgetMinutes > 0)) return Training{std::move(result), settings.training.steps, stage.key};
    // The budget alone is in the stage's key, and another run of it may have fitted other steps in.
    const uint32_t steps = probedSteps(stage.folder).value_or(settings.training.steps);
    return Training{std::move(result), steps, hashText(stage.key + " " + std::to_string(steps))};
}

}  // namespace dpl
