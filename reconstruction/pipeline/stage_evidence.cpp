// SPDX-License-Identifier: Apache-2.0
// The stage evidence measures how much each optional part improves the avatar. The public SDK draws validation frames with the part and
// without it, and both are scored. A validation frame is drawn in its registered pose after a pose fit, which moves joints and root only:
// to the whole avatar, and again to the avatar without the offsets, because a pose can stand in for these. A scan that is too small for a
// validation split is judged on training frames. Held-out frames are not used.
#include "reconstruction/pipeline/registered_pose.h"
#include "reconstruction/pipeline/stage_keys.h"
#include "reconstruction/pipeline/stages.h"
#include "reconstruction/priors.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/score.h"
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

struct Measured {
    double maskedPsnrDb = 0;
    uint64_t bytes = 0;
};

/** The frames that decide. */
struct Jury {
    std::vector<TrainFrame> frames;
    bool registered = true;  // validation frames in their registered poses; false: training frames in their trained poses
};

Result<Jury> chooseJury(const IngestedScan& ingested, const FittedBody& body, const RegisteredPoses& registered, const Training& training,
                        const AssembledAvatar& assembled, Pictures& pictures) {
    Jury jury;
    DPL_TRY(FrameSet set, framesOf(ingested, Split::Validation, body.cameras, registered.poses, pictures));
    const std::vector<const Pose*> trained = trainedPoses(ingested, training.result);
    for (size_t i = 0; i < set.frames.size(); ++i)
        set.frames[i].pose = registeredPose(ingested.scan, registered.poses, trained, set.indices[i]);
    jury.frames = std::move(set.frames);
    if (!jury.frames.empty()) return jury;
    jury.registered = false;
    std::vector<const TrainFrame*> chosen;
    chooseFrames(assembled.frames, FrameKind::Dynamic, chosen);
    chooseFrames(assembled.frames, FrameKind::StaticFull, chosen);
    for (const TrainFrame* frame : chosen) jury.frames.push_back(*frame);
    return jury;
}

/** Measures avatars on the jury's frames. */
class Judge {
public:
    Judge(const Jury& jury, const PoseFitSettings& poseFit, Jobs& jobs, StageContext& context)
        : jury_(jury), poseFit_(poseFit), jobs_(jobs), context_(context), posed_(jury.frames) {}

    /** Fits the poses of validation frames to an avatar, each from its registered pose. Later pictures are drawn in these poses. */
    Status fitPoses(const AvatarData& avatar, double from, double to) {
        for (size_t i = 0; i < posed_.size() && jury_.registered; ++i) {
            if (context_.progress.cancelled()) return fail(Code::Cancelled, "stopped");
            posed_[i].pose = jury_.frames[i].pose;
            if (auto fitted = fitPose(avatar, jury_.frames[i], poseFit_, jobs_)) posed_[i].pose = fitted->pose;
            context_.progress.update(from + (to - from) * double(i + 1) / double(posed_.size()), posed_[i].name);
        }
        return {};
    }

    Result<Measured> measure(const AvatarData& avatar) const {
        DPL_TRY(auto bytes, writeAvatar(avatar, kPackaged));
        DPL_TRY(auto view, AvatarView::open(bytes, jobs_.threadCount()));
        Measured m;
        m.bytes = bytes.size();
        for (const TrainFrame& frame : posed_) {
            DPL_TRY(auto picture, view.draw(frame.pose, frame.camera));
            m.maskedPsnrDb += scorePicture(picture, frame.picture->image, frame.picture->mask).maskedPsnrDb / double(posed_.size());
        }
        return m;
    }

private:
    const Jury& jury_;
    const PoseFitSettings& poseFit_;
    Jobs& jobs_;
    StageContext& context_;
    std::vector<TrainFrame> posed_;
};

const char* whyNotTrained(AvatarPart part, const RunSettings& settings) {
    if (part == AvatarPart::ViewDependentColour) return "not trained";
    if (part == AvatarPart::CorrectiveLight && settings.training.rateNodeLight == 0) return "not trained: left out by --without light";
    return "not trained: too few moving frames, or all in one pose";
}

Status weigh(const AssembledAvatar& assembled, const Jury& jury, const RunSettings& settings, Jobs& jobs, StageContext& context) {
    Judge judge(jury, settings.poseFit, jobs, context);
    DPL_CHECK_OK(judge.fitPoses(assembled.avatar, 0, 0.4));
    DPL_TRY(const Measured whole, judge.measure(assembled.avatar));
    const std::pair<AvatarPart, std::string> kParts[] = {
        {AvatarPart::CorrectiveOffsets, "pose-dependent offsets"},
        {AvatarPart::CorrectiveLight, "pose-dependent light"},
        {AvatarPart::ViewDependentColour, "view-dependent colour (SH degree " + std::to_string(assembled.avatar.splats.shDegree) + ")"}};
    std::vector<PartEvidence> rows;
    for (const auto& [part, name] : kParts) {
        if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
        if (!hasPart(assembled.avatar, part)) {
            rows.push_back({part, {name, false, 0, 0, whyNotTrained(part, settings)}});
            continue;
        }
        AvatarData without = assembled.avatar;
        removePart(without, part);
        // A pose can stand in for offsets, so the avatar without them gets poses of its own.
        Judge fair = judge;
        if (part == AvatarPart::CorrectiveOffsets) DPL_CHECK_OK(fair.fitPoses(without, 0.5, 0.9));
        DPL_TRY(const Measured rest, fair.measure(without));
        const double gain = whole.maskedPsnrDb - rest.maskedPsnrDb;
        const bool kept = gain >= priors::kWorthItDb;
        // A node value has eight bytes in the file: six of offset, two of light.
        const uint64_t values = uint64_t(assembled.avatar.correctives.nodes.size());
        const uint64_t bytes = part == AvatarPart::CorrectiveOffsets ? 6 * values
                               : part == AvatarPart::CorrectiveLight ? 2 * values
                                                                     : whole.bytes - std::min(whole.bytes, rest.bytes);
        rows.push_back({part,
                        {name, kept, float(gain), kept ? bytes : 0,
                         formatText("masked PSNR of {} {} frames with and without it in the trained avatar", jury.frames.size(),
                                    jury.registered ? "validation" : "training")}});
        context.progress.update(0.9 + 0.03 * double(rows.size()), name);
    }
    return writeEvidence(rows, context.folder / "evidence.json");
}

/** The files of validation frames, which this stage alone reads. Their keypoints reach it through the body fit. */
nlohmann::json juryInputs(const IngestedScan& ingested) {
    nlohmann::json out = nlohmann::json::array();
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f)
        if (ingested.scan.frames[f].split == Split::Validation)
            out.push_back({ingested.scan.frames[f].name, ingested.hashes[f].image, ingested.hashes[f].mask});
    return out;
}

}  // namespace

Result<MeasuredParts> runEvidence(const StageRun& run, const IngestedScan& ingested, const FittedBody& body,
                                  const RegisteredPoses& registered, const Training& training, Lazy<AssembledAvatar>& trained,
                                  Pictures& pictures, const RunSettings& settings) {
    const nlohmann::json inputs = {{"trained", training.key},
                                   {"register", registered.key},
                                   {"assemble", assembleInputs()},
                                   {"name", ingested.scan.name},
                                   {"worthItDb", priors::kWorthItDb},
                                   {"validation", juryInputs(ingested)},
                                   {"poseFit", fieldsJson(settings.poseFit)},
                                   {"framesOfAKind", kFramesOfAKind}};
    DPL_TRY(const StageOutput stage, run.chain.run("evidence", 4, inputs, [&](StageContext& context) -> Status {
        DPL_TRY(const AssembledAvatar* assembled, trained.get());
        DPL_TRY(const Jury jury, chooseJury(ingested, body, registered, training, *assembled, pictures));
        return weigh(*assembled, jury, settings, run.jobs, context);
    }));
    DPL_TRY(std::vector<PartEvidence> parts, readEvidence(stage.folder / "evidence.json"));
    return MeasuredParts{std::move(parts), stage.key};
}

}  // namespace dpl
