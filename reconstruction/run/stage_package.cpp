// SPDX-License-Identifier: Apache-2.0
// The stage package. The evidence decides which parts go into the file, a short polish runs on the decoded avatar, and the avatar is
// encoded.
#include <algorithm>

#include "reconstruction/run/stage_keys.h"
#include "reconstruction/run/stages.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

Status package(const AssembledAvatar& assembled, const std::vector<PartEvidence>& parts, const std::vector<EvidenceData>& decided,
               const CaptureMapData& capture, const RunSettings& settings, Jobs& jobs, StageContext& context) {
    AvatarData avatar = assembled.avatar;
    for (const PartEvidence& part : parts)
        if (!part.row.kept) removePart(avatar, part.part);
    dropEmptyCorrectives(avatar);
    avatar.evidence = decided;
    for (const PartEvidence& part : parts) avatar.evidence.push_back(part.row);
    const auto report = [&](const CoOptimiseProgress& p) {
        context.progress.update(0.1 + 0.85 * p.step / std::max(1u, p.steps), formatText("polish step {} of {}", p.step, p.steps));
    };
    DPL_TRY(avatar, polish(std::move(avatar), assembled.triangleLabel, assembled.frames, settings.polishSteps, settings.training.seed, jobs,
                           report, &context.progress.cancelFlag()));
    avatar.captureMap = capture;
    DPL_TRY(auto bytes, writeAvatar(avatar, kPackaged));
    return writeFileAtomically(context.folder / "avatar.glb", bytes);
}

}  // namespace

Result<Package> runPackage(const StageRun& run, const IngestedScan& ingested, const Training& training, Lazy<AssembledAvatar>& trained,
                           const MeasuredParts& measured, const std::vector<EvidenceData>& decided, const MappedBody& mapped,
                           const RunSettings& settings) {
    nlohmann::json rows = nlohmann::json::array();
    for (const EvidenceData& row : decided) rows.push_back({row.part, row.kept, row.reason});
    const nlohmann::json inputs = {{"trained", training.key}, {"assemble", assembleInputs()},     {"name", ingested.scan.name},
                                   {"parts", measured.key},   {"polish", polishInputs(settings)}, {"decided", rows},
                                   {"map", mapped.key}};
    DPL_TRY(const StageOutput stage, run.chain.run("package", 7, inputs, [&](StageContext& context) -> Status {
        context.progress.update(0, "encoding");
        DPL_TRY(const AssembledAvatar* assembled, trained.get());
        return package(*assembled, measured.parts, decided, mapped.capture, settings, run.jobs, context);
    }));
    DPL_TRY(auto bytes, readFile(stage.folder / "avatar.glb"));
    return Package{std::move(bytes), stage.key};
}

}  // namespace dpl
