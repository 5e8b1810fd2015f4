// SPDX-License-Identifier: Apache-2.0
// evidence: what is each optional part worth? It is taken out of the trained avatar, and training frames are scored with and without,
// through the public SDK. Held-out frames decide nothing: the report scores those afterwards.
#include "reconstruction/pipeline/assemble_avatar.h"
#include "reconstruction/pipeline/evidence_file.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/score.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

constexpr double kWorthItDb = 0.05;    // less is below what a change of seed does
constexpr size_t kFramesOfAKind = 12;  // scored: moving ones and still ones, evenly spaced

/** Evenly spaced frames of a kind. */
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
        m.maskedPsnrDb += scorePicture(picture, frame->image, frame->mask).maskedPsnrDb / double(frames.size());
    }
    return m;
}

Status weigh(const SubjectData& subject, StageContext& context) {
    DPL_TRY(AssembledAvatar assembled, assembleAvatar(subject));
    std::vector<const TrainFrame*> frames;
    chooseFrames(assembled.frames, FrameKind::Dynamic, frames);
    chooseFrames(assembled.frames, FrameKind::StaticFull, frames);
    DPL_TRY(const Measured whole, measure(assembled.avatar, frames, subject.options.threadCount));
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
        DPL_TRY(const Measured rest, measure(without, frames, subject.options.threadCount));
        const double gain = whole.maskedPsnrDb - rest.maskedPsnrDb;
        const bool kept = gain >= kWorthItDb;
        // Node values of one kind keep their place in the file while the other kind is there: six bytes of eight, or two.
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

Status runEvidence(SubjectData& subject) {
    const nlohmann::json inputs = {{"trained", subject.chain.keyOf("co-optimise")}, {"name", subject.scan.name}};
    auto folder = subject.chain.run("evidence", 2, inputs, [&](StageContext& context) { return weigh(subject, context); });
    if (!folder) return folder.error();
    subject.evidenceFolder = *folder;
    return {};
}

}  // namespace dpl
