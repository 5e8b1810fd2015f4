// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_evidence.h"

#include <algorithm>
#include <cstdio>

#include "reconstruction/judging/evidence/jury_scores.h"
#include "reconstruction/judging/evidence/priors.h"
#include "reconstruction/judging/report/detail.h"
#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/run/carried_pose.h"
#include "reconstruction/run/resumed_training.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_assemble.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_register.h"
#include "reconstruction/training/trainer/pose_fitter.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr size_t kFramesOfAKind = 12;  // scored training frames of each kind (moving, still), where no validation frame exists

/** Adds up to kFramesOfAKind evenly spaced frames of a kind to `chosen`. */
void chooseFrames(const std::vector<TrainFrame>& frames, FrameKind kind, std::vector<const TrainFrame*>& chosen) {
    std::vector<const TrainFrame*> all;
    for (const TrainFrame& frame : frames)
        if (frame.kind == kind) all.push_back(&frame);
    const auto spaced = evenlySpaced(all, kFramesOfAKind);
    chosen.insert(chosen.end(), spaced.begin(), spaced.end());
}

/** The frames that decide. */
struct Jury {
    std::vector<TrainFrame> frames;
    bool registered = true;  // validation frames in their registered poses; false: training frames in their trained poses

    size_t closeups() const {
        return size_t(std::count_if(frames.begin(), frames.end(), [](const TrainFrame& f) { return f.kind == FrameKind::StaticCloseup; }));
    }
    /** Frames whose PSNR decides: a close-up shows too little of the subject. */
    size_t judging() const { return frames.size() - closeups(); }
};

struct Mean {
    double sum = 0;
    size_t count = 0;
    void add(double value) { sum += value, ++count; }
    double value() const { return count > 0 ? sum / double(count) : 0; }
};

Result<Jury> chooseJury(StageInputs& in, const AssembledAvatar& assembled) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const RegisteredPoses* registered, in.of<RegisteredPoses>());
    DPL_TRY(const Training* training, in.of<Training>());
    Jury jury;
    DPL_TRY(FrameSet set, registeredFrames(in, Split::Validation));
    const std::vector<Pose> poses =
        posesAfterTraining(*table, registered->poses.poses, training->result, assembled.avatar.correctives.motion, HeldOut::Unknown);
    for (size_t i = 0; i < set.frames.size(); ++i) set.frames[i].pose = poses[set.rows[i]];
    jury.frames = std::move(set.frames);
    if (jury.judging() > 0) return jury;
    jury.frames.clear();
    jury.registered = false;
    std::vector<const TrainFrame*> chosen;
    chooseFrames(assembled.frames, FrameKind::Dynamic, chosen);
    chooseFrames(assembled.frames, FrameKind::StaticFull, chosen);
    for (const TrainFrame* frame : chosen) jury.frames.push_back(*frame);
    return jury;
}

uint32_t stepsOfTrainingOn(const RunSettings& settings) {
    return uint32_t(std::max(20.0, priors::kRetrainShare * settings.training.steps));
}

/** How the stage's work divides, for its progress. Units: steps of training. */
struct Work {
    Work(const Jury& jury, const RunSettings& settings, size_t avatarCount) : avatars(avatarCount), steps(stepsOfTrainingOn(settings)) {
        constexpr double kRound = 0.6;  // of a pose fit; it only moves the bar
        if (jury.registered) posing = kRound * double(jury.frames.size()) * settings.poseFit.iterations;
    }
    double avatar() const { return steps + PoseFitter::kSecondFit * posing; }
    double firstShare() const { return posing / (posing + double(avatars) * avatar()); }
    double avatarShare() const { return (1 - firstShare()) / double(avatars); }
    /** Of an avatar's work, before it is drawn. */
    double trainingShare() const { return kBeforeDrawing * steps / avatar(); }

    static constexpr double kBeforeDrawing = 0.95;
    size_t avatars;
    double steps, posing = 0;
};

/** Trains avatars on and scores them on the jury's frames. A stopped stage keeps the scores that it has, and a checkpoint of the avatar
 * that it was at, in context.folder. */
class Judge {
public:
    Judge(const AssembledAvatar& assembled, const Jury& jury, const Work& work, const RunSettings& settings, Jobs& jobs,
          StageContext& context)
        : assembled_(assembled),
          jury_(jury),
          work_(work),
          settings_(settings),
          jobs_(jobs),
          context_(context),
          scores_(context.folder / "scores.json") {}

    /** Fits the jury's poses to the avatar as training left it. The avatars that are judged differ from it by a little, so their own fits
     * start there and run their last rounds only. */
    Status fitPoses() {
        if (!jury_.registered) return {};
        DPL_TRY(const auto bytes, writeAvatar(assembled_.avatar, {}));
        DPL_TRY(const AvatarData decoded, readAvatar(bytes));
        DPL_TRY(poses_, PoseFitter(decoded, jobs_).fitAll(jury_.frames, settings_.poseFit, jobs_));
        return {};
    }

    /** The score of `avatar` after it was trained on. name: of the avatar, for the next run. */
    Result<JuryScore> score(const std::string& name, AvatarData avatar, const RetrainParts& parts) {
        if (const auto known = scores_.find(name)) return *known;
        const std::filesystem::path checkpoint = context_.folder / ("without-" + name + ".checkpoint");
        {
            const TaskPart part(0, work_.trainingShare());
            DPL_TRY(avatar, trainedOn(std::move(avatar), parts, assembled_, settings_, jobs_, checkpoint, context_.progress));
        }
        DPL_TRY(const JuryScore score, scoreOf(avatar));
        DPL_RETURN_IF_ERROR(scores_.add(name, score));
        std::error_code ignored;
        std::filesystem::remove(checkpoint, ignored);
        return score;
    }

private:
    Result<JuryScore> scoreOf(const AvatarData& avatar) const {
        DPL_TRY(const auto bytes, writeAvatar(avatar, {}));
        DPL_TRY(const AvatarData decoded, readAvatar(bytes));
        std::vector<std::optional<PoseFitResult>> fits(jury_.frames.size());
        if (jury_.registered) {
            const TaskPart fitting(work_.trainingShare(), Work::kBeforeDrawing);
            DPL_TRY(fits, PoseFitter(decoded, jobs_).fitAll(jury_.frames, settings_.poseFit, jobs_, poses_));
        }
        const TaskPart scoring(Work::kBeforeDrawing, 1);
        DPL_TRY(auto view, AvatarView::open(bytes, jobs_.threadCount()));
        JuryScore sum;
        Mean psnrDb, detail, closeDetail;
        for (size_t i = 0; i < jury_.frames.size(); ++i) {
            const TrainFrame& frame = jury_.frames[i];
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(jury_.frames.size()), frame.name));
            DPL_TRY(const auto picture, view.draw(fits[i] ? fits[i]->pose : frame.pose, frame.camera));
            DPL_TRY(const auto shown, frame.picture.get());
            const auto truth = cutOut(shown->image, shown->mask);
            const uint32_t width = frame.camera.widthPx, height = frame.camera.heightPx;
            const bool closeup = frame.kind == FrameKind::StaticCloseup;
            if (!closeup) psnrDb.add(scorePicture(picture, truth, width, height).maskedPsnrDb);
            if (const auto d = detailCorrelation(picture, truth, width, height)) (closeup ? closeDetail : detail).add(*d);
        }
        sum.maskedPsnrDb = psnrDb.value(), sum.detail = closeDetail.count > 0 ? closeDetail.value() : detail.value();
        DPL_TRY(sum.faults, motionFaults(decoded, view, jury_.frames, jobs_));
        return sum;
    }

    const AssembledAvatar& assembled_;
    const Jury& jury_;
    const Work work_;
    const RunSettings& settings_;
    Jobs& jobs_;
    StageContext& context_;
    JuryScores scores_;
    std::vector<std::optional<PoseFitResult>> poses_;  // of the jury's frames, fitted to the avatar as training left it
};

std::string decimals(double value, int digits) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

const char* whyNotTrained(AvatarPart part, const RunSettings& settings) {
    if (part == AvatarPart::ViewDependentColour) return "not trained";
    if (part == AvatarPart::CorrectiveLight && settings.training.rateNodeLight == 0) return "not trained: left out by --without light";
    if (part == AvatarPart::MotionModes && !settings.training.learnMotion) return "not trained: left out by --without motion";
    if (part == AvatarPart::SceneLight)
        return settings.training.learnLight ? "not found: too few moving frames, or surfaces that are seen both still and moving"
                                            : "not looked for: left out by --without light";
    if (part == AvatarPart::MotionModes) return "not trained: too few frames that have moved, or no still frames";
    return "not trained: too few moving frames, or all in one pose";
}

Status weigh(const AssembledAvatar& assembled, const Jury& jury, const RunSettings& settings, Jobs& jobs, StageContext& context) {
    const AvatarData& avatar = assembled.avatar;
    const std::pair<AvatarPart, std::string> kParts[] = {
        {AvatarPart::CorrectiveOffsets, "pose-dependent offsets"},
        {AvatarPart::CorrectiveLight, "pose-dependent light"},
        {AvatarPart::MotionModes, "motion modes: clothes that have moved"},
        {AvatarPart::SceneLight, "light that stays while the subject turns"},
        {AvatarPart::ViewDependentColour, "view-dependent colour (SH degree " + std::to_string(avatar.splats.shDegree) + ")"}};
    const auto isThere = [&](const auto& part) { return hasPart(avatar, part.first); };
    const Work work(jury, settings, 1 + size_t(std::count_if(std::begin(kParts), std::end(kParts), isThere)));
    Judge judge(assembled, jury, work, settings, jobs, context);
    double done = work.firstShare();
    {
        const TaskPart part(0, done);
        DPL_RETURN_IF_ERROR(judge.fitPoses());
    }
    const RetrainParts trained{.correctiveLight = settings.training.rateNodeLight > 0};
    const auto score = [&](const char* without, AvatarData judged, const RetrainParts& parts) {
        const double from = done;
        done = std::min(1.0, done + work.avatarShare());
        const TaskPart part(from, done);
        return judge.score(without, std::move(judged), parts);
    };
    DPL_TRY(const JuryScore whole, score("nothing", avatar, trained));
    DPL_TRY(const auto wholeFile, writeAvatar(avatar, kPackaged));
    std::vector<PartEvidence> rows;
    for (const auto& [part, name] : kParts) {
        if (!hasPart(avatar, part)) {
            rows.push_back({part, {name, false, 0, 0, whyNotTrained(part, settings)}});
            continue;
        }
        AvatarData without = avatar;
        removePart(without, part);
        DPL_TRY(const auto file, writeAvatar(without, kPackaged));
        RetrainParts parts = trained;
        if (part == AvatarPart::CorrectiveOffsets) parts.correctiveOffsets = false;
        if (part == AvatarPart::CorrectiveLight) parts.correctiveLight = false;
        DPL_TRY(const JuryScore rest, score(nameOf(part), std::move(without), parts));
        const uint64_t bytes = wholeFile.size() - std::min(wholeFile.size(), file.size());
        const double gain = whole.maskedPsnrDb - rest.maskedPsnrDb,
                     price = priors::kWorthItDb + priors::kWorthAMegabyteDb * double(bytes) / 1e6;
        const bool kept = gain >= price;
        rows.push_back(
            {part,
             {name, kept, float(gain), kept ? bytes : 0,
              formatText("masked PSNR of {} {} frames against an avatar that was trained on without it; {} KB must gain {} dB; "
                         "correlation of fine detail {}{}, without it {}; flicker {} levels, without it {}; clothes inside the "
                         "body {} %, without it {} %",
                         jury.judging(), jury.registered ? "validation" : "training", (bytes + 500) / 1000, decimals(price, 3),
                         jury.closeups() > 0 ? formatText("on {} close-ups ", jury.closeups()) : "", decimals(whole.detail, 3),
                         decimals(rest.detail, 3), decimals(whole.faults.flickerLevels, 2), decimals(rest.faults.flickerLevels, 2),
                         decimals(100 * whole.faults.penetration, 2), decimals(100 * rest.faults.penetration, 2))}});
    }
    return writeEvidence(rows, context.folder / "evidence.json");
}

/** The files of validation frames, which this stage alone reads. Their keypoints reach it through the body fit. */
nlohmann::json juryInputs(const FrameTable& table) {
    nlohmann::json out = nlohmann::json::array();
    for (size_t row = 0; row < table.rows(); ++row)
        if (table.scan.frames[row].split == Split::Validation)
            out.push_back({table.scan.frames[row].name, table.hashes[row].image, table.hashes[row].mask});
    return out;
}

}  // namespace

Result<AvatarData> trainedOn(AvatarData avatar, const RetrainParts& parts, const AssembledAvatar& assembled, const RunSettings& settings,
                             Jobs& jobs, const std::filesystem::path& checkpoint, Progress& progress) {
    const CoOptimiseSettings training = retrainSettings(settings.training, parts, stepsOfTrainingOn(settings), avatar.splats.shDegree);
    return retrain(std::move(avatar), assembled.triangleLabel, assembled.frames, training, jobs,
                   [&](CoOptimiser& trainer) { return trainFromCheckpoint(trainer, checkpoint, settings.checkpointS, progress); });
}

Status StageOf<MeasuredParts>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    DPL_TRY(const SettingsAfterTraining* after, in.part<SettingsAfterTraining>());
    in.value("training", trainingInputs(after->settings));
    in.value("validation", juryInputs(*table));
    in.value("poseFit", fieldsJson(after->settings.poseFit));
    in.value("framesOfAKind", kFramesOfAKind);
    DPL_RETURN_IF_ERROR(in.use<RegisteredPoses>());
    DPL_RETURN_IF_ERROR(in.use<Training>());
    return in.use<AssembledAvatar>();
}

Status StageOf<MeasuredParts>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const SettingsAfterTraining* after, in.of<SettingsAfterTraining>());
    DPL_TRY(const AssembledAvatar* assembled, in.of<AssembledAvatar>());
    DPL_TRY(const Jury jury, chooseJury(in, *assembled));
    return weigh(*assembled, jury, after->settings, in.jobs(), context);
}

Result<MeasuredParts> StageOf<MeasuredParts>::read(StageInputs&, const std::filesystem::path& folder) {
    DPL_TRY(std::vector<PartEvidence> parts, readEvidence(folder / "evidence.json"));
    return MeasuredParts{std::move(parts)};
}

}  // namespace dpl
