// SPDX-License-Identifier: Apache-2.0
// The stage evidence measures how much each optional part improves the avatar. The public SDK draws training frames with the part and
// without it, and both are scored. Held-out frames are not used.
#include "reconstruction/pipeline/stages.h"
#include "reconstruction/priors.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/score.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

constexpr size_t kFramesOfAKind = 12;  // scored frames of each kind (moving, still)

/** Adds up to kFramesOfAKind evenly spaced frames of a kind to `chosen`. */
void chooseFrames(const std::vector<TrainFrame>& frames, FrameKind kind, std::vector<const TrainFrame*>& chosen) {
    std::vector<const TrainFrame*> all;
    for (const TrainFrame& frame : frames)
        if (frame.kind == kind) all.push_back(&frame);
    const size_t count = std::min(kFramesOfAKind, all.size());
    for (size_t i = 0; i < count; ++i) chosen.push_back(all[(2 * i + 1) * all.size() / (2 * count)]);
}

struct Measured {
    double maskedPsnrDb = 0;
    uint64_t bytes = 0;
};

Result<Measured> measure(const AvatarData& avatar, const std::vector<const TrainFrame*>& frames, uint32_t threadCount) {
    DPL_TRY(auto bytes, writeAvatar(avatar, {.shPalette = true}));
    DPL_TRY(auto view, AvatarView::open(bytes, threadCount));
    Measured m;
    m.bytes = bytes.size();
    for (const TrainFrame* frame : frames) {
        DPL_TRY(auto picture, view.draw(frame->pose, frame->camera));
        m.maskedPsnrDb += scorePicture(picture, frame->picture->image, frame->picture->mask).maskedPsnrDb / double(frames.size());
    }
    return m;
}

Status weigh(const AssembledAvatar& assembled, uint32_t threadCount, StageContext& context) {
    std::vector<const TrainFrame*> frames;
    chooseFrames(assembled.frames, FrameKind::Dynamic, frames);
    chooseFrames(assembled.frames, FrameKind::StaticFull, frames);
    DPL_TRY(const Measured whole, measure(assembled.avatar, frames, threadCount));
    const std::pair<AvatarPart, std::string> kParts[] = {
        {AvatarPart::CorrectiveOffsets, "pose-dependent offsets"},
        {AvatarPart::CorrectiveLight, "pose-dependent light"},
        {AvatarPart::ViewDependentColour, "view-dependent colour (SH degree " + std::to_string(assembled.avatar.splats.shDegree) + ")"}};
    std::vector<PartEvidence> rows;
    for (const auto& [part, name] : kParts) {
        if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
        if (!hasPart(assembled.avatar, part)) {
            rows.push_back(
                {part,
                 {name, false, 0, 0,
                  part == AvatarPart::ViewDependentColour ? "not trained" : "not trained: too few moving frames, or all in one pose"}});
            continue;
        }
        AvatarData without = assembled.avatar;
        removePart(without, part);
        DPL_TRY(const Measured rest, measure(without, frames, threadCount));
        const double gain = whole.maskedPsnrDb - rest.maskedPsnrDb;
        const bool kept = gain >= priors::kWorthItDb;
        // A node value has eight bytes in the file: six of offset, two of light.
        const uint64_t values = uint64_t(assembled.avatar.correctives.nodes.size());
        const uint64_t bytes = part == AvatarPart::CorrectiveOffsets ? 6 * values
                               : part == AvatarPart::CorrectiveLight ? 2 * values
                                                                     : whole.bytes - std::min(whole.bytes, rest.bytes);
        rows.push_back({part,
                        {name, kept, float(gain), kept ? bytes : 0,
                         formatText("masked PSNR of {} training frames with and without it in the trained avatar", frames.size())}});
        context.progress.update(double(rows.size()) / 3, name);
    }
    return writeEvidence(rows, context.folder / "evidence.json");
}

}  // namespace

Result<MeasuredParts> runEvidence(const StageRun& run, const IngestedScan& ingested, const Training& training,
                                  Lazy<AssembledAvatar>& trained) {
    const nlohmann::json inputs = {{"trained", training.key},
                                   {"assemble", assembleInputs()},
                                   {"name", ingested.scan.name},
                                   {"worthItDb", priors::kWorthItDb},
                                   {"framesOfAKind", kFramesOfAKind}};
    DPL_TRY(const StageOutput stage, run.chain.run("evidence", 2, inputs, [&](StageContext& context) -> Status {
        DPL_TRY(const AssembledAvatar* assembled, trained.get());
        return weigh(*assembled, run.jobs.threadCount(), context);
    }));
    DPL_TRY(std::vector<PartEvidence> parts, readEvidence(stage.folder / "evidence.json"));
    return MeasuredParts{std::move(parts), stage.key};
}

}  // namespace dpl
