// SPDX-License-Identifier: Apache-2.0
// package: what is trained is what ships. The evidence decides what goes in; a short polish runs on the decoded bytes; encode.
#include <algorithm>

#include "reconstruction/pipeline/assemble_avatar.h"
#include "reconstruction/pipeline/evidence_file.h"
#include "reconstruction/pipeline/preset.h"
#include "reconstruction/splat/polish.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

Status package(SubjectData& subject, StageContext& context) {
    context.progress.update(0, "encoding");
    DPL_TRY(AssembledAvatar assembled, assembleAvatar(subject));
    DPL_TRY(std::vector<PartEvidence> parts, readEvidence(subject.evidenceFolder / "evidence.json"));
    AvatarData& avatar = assembled.avatar;
    for (const PartEvidence& part : parts)
        if (!part.row.kept) removePart(avatar, part.part);
    dropEmptyCorrectives(avatar);
    avatar.evidence = subject.evidence;
    for (const PartEvidence& part : parts) avatar.evidence.push_back(part.row);

    const PresetSettings preset = presetOf(subject.options.preset);
    const uint32_t polishSteps =
        subject.options.steps > 0 ? std::min(preset.polishSteps, std::max(20u, subject.options.steps / 10)) : preset.polishSteps;
    DPL_TRY([[maybe_unused]] CoOptimiseResult polished,
            polish(
                avatar, std::move(assembled.frames), polishSteps, subject.options.seed, subject.jobs,
                [&](const CoOptimiseProgress& p) {
                    context.progress.update(0.1 + 0.85 * p.step / std::max(1u, p.steps),
                                            formatText("polish step {} of {}", p.step, p.steps));
                },
                &context.progress.cancelFlag()));
    DPL_TRY(auto bytes, writeAvatar(avatar, {.shPalette = true}));
    return writeFileAtomically(context.folder / "avatar.glb", bytes);
}

}  // namespace

Status runPackage(SubjectData& subject) {
    nlohmann::json evidence = nlohmann::json::array();
    for (const EvidenceData& e : subject.evidence) evidence.push_back({e.part, e.kept, e.reason});
    const nlohmann::json inputs = {{"trained", subject.chain.keyOf("co-optimise")},
                                   {"parts", subject.chain.keyOf("evidence")},
                                   {"evidence", evidence},
                                   {"name", subject.scan.name}};
    auto folder = subject.chain.run("package", 3, inputs, [&](StageContext& context) { return package(subject, context); });
    if (!folder) return folder.error();
    subject.packageFolder = *folder;
    DPL_TRY(auto bytes, readFile(*folder / "avatar.glb"));
    return writeFileAtomically(subject.options.out / "avatar.glb", bytes);
}

}  // namespace dpl
