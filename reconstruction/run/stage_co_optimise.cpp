// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_co_optimise.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/moved_start.h"
#include "reconstruction/run/resumed_training.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_garments.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_register.h"
#include "reconstruction/run/time_left.h"
#include "reconstruction/run/trained_file.h"
#include "reconstruction/run/training_device.h"
#include "reconstruction/run/training_shown.h"
#include "reconstruction/training/correctives/corrective_model.h"
#include "reconstruction/training/correctives/motion_model.h"
#include "reconstruction/training/light/light_model.h"
#include "reconstruction/training/trainer/profile_steps.h"
#include "reconstruction/training/trainer/train_images.h"
#include "sdk/avatar/stress_poses.h"
#include "sdk/core/files.h"
#include "sdk/format/motion_modes.h"

namespace dpl {
namespace {

constexpr uint32_t kProbeSteps = 60;
constexpr uint32_t kFewSteps = 10;  // a budget with less than this part of the preset's steps is better spent by a smaller preset

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Result<CoOptimiseInput> trainingInput(const FittedBody& body, const GarmentLayers& layers, bool withMotion, const Scan& scan,
                                      FrameSet set) {
    std::vector<TrainFrame>& frames = set.frames;
    CoOptimiseInput input;
    input.joints = body.shaped.joints;
    input.mesh = layers.clothed.mesh;
    input.triangleLabel = layers.clothed.triangleLabel;
    DPL_TRY(input.correctives, correctiveModel(input.joints, input.mesh, movingPoses(frames)));
    if (withMotion && !input.correctives.empty()) {
        DPL_TRY(MotionModeData motion, motionModel(input.joints, stillPoses(frames), movingPoses(frames), movingTimesS(scan, set.rows)));
        rememberFrames(scan, motion, set);
        addMotionModes(input.correctives, std::move(motion));
    }
    input.stress = stressPoses(input.joints);
    for (const TrainFrame& frame : frames)  // strange poses come to those who have moved
        if (frame.kind == FrameKind::Dynamic)
            for (Pose& pose : input.stress) pose.before.held = frame.pose.before.held;
    input.frames = std::move(frames);
    return input;
}

constexpr const char *kStepsFile = "steps.txt", *kCheckpointFile = "checkpoint", *kTrainedFile = "trained.bin", *kEngineFile = "engine.txt";

/** The number of steps that a probe found for this run. None before it. */
std::optional<uint32_t> probedSteps(const std::filesystem::path& folder) {
    const auto bytes = readFile(folder / kStepsFile, 64);
    if (!bytes) return std::nullopt;
    return uint32_t(std::max(1L, std::strtol(std::string(bytes->begin(), bytes->end()).c_str(), nullptr, 10)));
}

/** Who trains. */
struct Trainers {
    Jobs& jobs;
    std::unique_ptr<TrainingEngine> engine;  // null: the CPU
};

/** The steps with which the whole run keeps its time budget, by timing a short probe run of the slowest steps. spentS: of the budget, on
 * the stages before. The number is stored beside the checkpoint, so that a continued run uses the same one. */
Result<uint32_t> stepsInBudget(const CoOptimiseInput& input, const RunSettings& settings, double spentS, const Trainers& trainers,
                               const StageContext& context) {
    if (const auto steps = probedSteps(context.folder)) return *steps;
    DPL_TRY(auto probe, CoOptimiser::create(input, slowestSteps(settings.training), trainers.jobs, trainers.engine.get()));
    const auto start = std::chrono::steady_clock::now();
    DPL_RETURN_IF_ERROR(probe->run(kProbeSteps));
    const double probeS = secondsSince(start), leftS = settings.timeBudgetMinutes * 60 - spentS - probeS;
    const uint32_t steps = stepsWithin(leftS, probeS / kProbeSteps, {0, settings.polishSteps, settings.poseFit.iterations});
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / kStepsFile, std::to_string(steps)));
    context.progress.note(
        formatText("{} steps of training fit into the time budget, of which {} s are spent{}", steps, std::lround(spentS),
                   steps == kLeastSteps ? ". They are the fewest, and the run will take longer than it; give it more"
                   : steps < settings.training.steps / kFewSteps
                       ? ". They are few for this preset, whose other stages take most of the time; a smaller one makes more of it"
                       : ""));
    return steps;
}

Status train(const CoOptimiseInput& input, const RunSettings& settings, double spentS, Jobs& jobs, StageContext& context,
             TrainingShown shown) {
    CoOptimiseSettings training = settings.training;
    DPL_TRY(auto engine, engineOf(settings.device, context.progress));
    Trainers trainers{jobs, std::move(engine)};
    if (settings.timeBudgetMinutes > 0) {
        DPL_TRY(training.steps, stepsInBudget(input, settings, spentS, trainers, context));
    }
    const auto trainOn = [&](TrainingEngine* with) -> Status {
        DPL_TRY(auto optimiser, CoOptimiser::create(input, training, jobs, with));
        if (!settings.from.empty()) {
            DPL_TRY(const std::string changes, optimiser->branch(settings.from));
            context.progress.note(formatText("going on from step {} of {}; {}", optimiser->step(), settings.from.string(),
                                             changes.empty() ? "nothing changed" : "changed: " + changes));
        }
        DPL_RETURN_IF_ERROR(trainFromCheckpoint(*optimiser, context.folder / kCheckpointFile, settings.checkpointS, context.progress,
                                                [&] { shown.after(*optimiser, training.steps); }));
        return writeTrainedFile(optimiser->result(), context.folder / kTrainedFile);
    };
    const TrainingFiles files{context.folder / kCheckpointFile, context.folder / kEngineFile};
    return trainOnDevice(settings.device, trainers.engine.get(), files, context.progress, trainOn);
}

/** What is trained, from the artefacts that StageOf<Training> pulls. */
Result<CoOptimiseInput> inputOfStage(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const GarmentLayers* layers, in.of<GarmentLayers>());
    (void)taskAt(0, "reading pictures");  // a stop is heard by the training, which leaves a checkpoint
    DPL_TRY(FrameSet set, registeredFrames(in, Split::Train));
    if (set.frames.empty()) return fail(Code::InvalidArgument, "no usable training frames");
    DPL_TRY(CoOptimiseInput input, trainingInput(*body, *layers, settings->training.learnMotion, table->scan, std::move(set)));
    if (settings->training.learnLight) {
        DPL_TRY(const LightFit fit, findLight(input.joints, input.mesh, input.frames, in.jobs()));
        input.light = fit.light;
        if (!fit.light.empty())
            in.progress().detail(formatText("light: brightness of moving surfaces strays by {} % before and {} % after it is known",
                                            std::round(1e3 * fit.strayBefore) / 10, std::round(1e3 * fit.strayAfter) / 10));
    }
    DPL_TRY(const MovedStart start, startMovedColumn(input, in.jobs()));
    if (start.views > 0)
        in.progress().detail(formatText("outlines of {} moving pictures: overlap {} before and {} after clothes have moved", start.views,
                                        std::round(1e3 * start.iouBefore) / 1e3, std::round(1e3 * start.iouAfter) / 1e3));
    return input;
}

Result<CoOptimiseResult> readTrained(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const GarmentLayers* layers, in.of<GarmentLayers>());
    const MeshData& mesh = layers->clothed.mesh;
    return readTrainedFile(folder / kTrainedFile, mesh.triangles.size(), mesh.restPositions.size(), body->shaped.joints.size());
}

/** The steps that the training in `folder` took. */
uint32_t stepsTaken(const RunSettings& settings, const std::filesystem::path& folder) {
    return settings.timeBudgetMinutes > 0 ? probedSteps(folder).value_or(settings.training.steps) : settings.training.steps;
}

}  // namespace

Status StageOf<Training>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY(const RunSettings* settings, in.part<RunSettings>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    in.value("training", table->trainingHash);
    in.value("settings", trainingInputs(*settings));
    if (settings->device.kind == TrainingDevice::Kind::Gpu) in.value("engine", "gpu");
    if (!settings->from.empty()) {
        DPL_TRY(const std::string hash, hashFile(settings->from));
        in.value("from", hash);
    }
    DPL_RETURN_IF_ERROR(in.use<FittedBody>());
    DPL_RETURN_IF_ERROR(in.use<GarmentLayers>());
    return in.use<RegisteredPoses>();
}

Status StageOf<Training>::make(StageInputs& in, StageContext& context) {
    const auto dropCheckpoint = [&]() -> Status {
        std::error_code ignored;
        std::filesystem::remove(context.folder / kCheckpointFile, ignored);
        return {};
    };
    if (readTrained(in, context.folder)) return dropCheckpoint();  // a run that was killed after its last file
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    context.progress.detail(
        formatText("pictures at the size of a training level are kept up to {} MiB", CoOptimiseInput().levelBoundBytes >> 20));
    const auto began = std::chrono::steady_clock::now();
    double spentS = 0;
    for (const StageRecord& stage : in.records()) spentS += stage.seconds;
    DPL_TRY(CoOptimiseInput input, inputOfStage(in));
    spentS += secondsSince(began);
    TrainingShown shown(context.progress.news(), input);
    shown.heldBack(*table);
    DPL_RETURN_IF_ERROR(train(input, *settings, spentS, in.jobs(), context, std::move(shown)));
    return dropCheckpoint();
}

Result<Training> StageOf<Training>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    DPL_TRY(CoOptimiseResult result, readTrained(in, folder));
    return Training{std::move(result), stepsTaken(*settings, folder)};
}

Result<std::string> StageOf<Training>::keyAfter(StageInputs& in, const std::filesystem::path& folder, const std::string& key) {
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    std::string after = key;
    if (settings->timeBudgetMinutes > 0) after = hashText(after + " " + std::to_string(stepsTaken(*settings, folder)));
    if (settings->device.kind == TrainingDevice::Kind::Auto && std::filesystem::exists(folder / kEngineFile))
        after = hashText(after + " gpu");
    return after;
}

Status StageOf<ProfiledTraining>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const ProfiledSteps* steps, in.part<ProfiledSteps>());
    return StageOf<Training>::inputs(in);
}

Result<ProfiledTraining> StageOf<ProfiledTraining>::compute(StageInputs& in) {
    DPL_TRY(const ProfiledSteps* steps, in.of<ProfiledSteps>());
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    DPL_TRY(CoOptimiseInput input, inputOfStage(in));
    DPL_TRY(const auto engine, engineOf(settings->device, in.progress()));
    return profileSteps(std::move(input), settings->training, *steps, in.jobs(), engine.get());
}

Status StageOf<SettingsAfterTraining>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const RunSettings* settings, in.part<RunSettings>());
    return in.use<Training>();
}

Result<SettingsAfterTraining> StageOf<SettingsAfterTraining>::compute(StageInputs& in) {
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    DPL_TRY(const Training* training, in.of<Training>());
    return SettingsAfterTraining{withTrainingSteps(*settings, training->steps)};
}

}  // namespace dpl
