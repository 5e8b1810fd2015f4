// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_package.h"

#include <algorithm>

#include "reconstruction/output/package/lone_splats.h"
#include "reconstruction/run/hidden_parts.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_assemble.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_body_map.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_evidence.h"
#include "reconstruction/run/stage_garments.h"
#include "reconstruction/subject/face/body_face.h"
#include "reconstruction/training/trainer/polish.h"
#include "sdk/core/files.h"
#include "sdk/core/log.h"

namespace dpl {

Status StageOf<Package>::inputs(StageInputs& in) {
    DPL_TRY(const SettingsAfterTraining* after, in.part<SettingsAfterTraining>());
    DPL_TRY(const GarmentLayers* layers, in.part<GarmentLayers>());
    nlohmann::json rows = nlohmann::json::array();
    for (const EvidenceData& row : layers->decided) rows.push_back({row.part, row.kept, row.reason});
    in.value("decided", rows);
    in.value("polish", polishInputs(after->settings));
    in.value("training", trainingInputs(after->settings));
    DPL_TRY(const ChosenBody* chosen, in.part<ChosenBody>());
    in.value("face", chosen->faceHash);
    DPL_RETURN_IF_ERROR(in.use<MappedBody>());
    DPL_RETURN_IF_ERROR(in.use<AssembledAvatar>());
    return in.use<MeasuredParts>();
}

Status StageOf<Package>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const SettingsAfterTraining* after, in.of<SettingsAfterTraining>());
    DPL_TRY(const GarmentLayers* layers, in.of<GarmentLayers>());
    DPL_TRY(const ChosenBody* chosen, in.of<ChosenBody>());
    DPL_TRY(const MappedBody* mapped, in.of<MappedBody>());
    DPL_TRY(const MeasuredParts* measured, in.of<MeasuredParts>());
    DPL_TRY(const AssembledAvatar* assembled, in.of<AssembledAvatar>());
    const RunSettings& settings = after->settings;
    AvatarData avatar = assembled->avatar;
    RetrainParts learns{.correctiveLight = settings.training.rateNodeLight > 0};
    bool makesUp = false;  // for correctives; colour alone needs no more than the polish
    for (const PartEvidence& part : measured->parts) {
        if (part.row.kept) continue;
        if (part.part == AvatarPart::CorrectiveOffsets) learns.correctiveOffsets = false;
        if (part.part == AvatarPart::CorrectiveLight) learns.correctiveLight = false;
        makesUp |= part.part != AvatarPart::ViewDependentColour && hasPart(avatar, part.part);
        removePart(avatar, part.part);
    }
    dropEmptyCorrectives(avatar);
    const std::filesystem::path checkpoint = context.folder / "checkpoint";
    if (makesUp) {
        const TaskPart part(0, 0.5);
        DPL_TRY(avatar, trainedOn(std::move(avatar), learns, *assembled, settings, in.jobs(), checkpoint, context.progress));
        DPL_TRY(avatar, asReadersDecode(avatar, in.jobs()));
        mendGarments(avatar);
    }
    avatar.evidence = layers->decided;
    for (const PartEvidence& part : measured->parts) avatar.evidence.push_back(part.row);
    {
        const TaskPart part(makesUp ? 0.5 : 0, 0.95);
        DPL_TRY(avatar, polish(std::move(avatar), assembled->triangleLabel, assembled->frames, settings.polishSteps, settings.training.seed,
                               in.jobs()));
    }
    const TaskPart part(0.95, 1);
    DPL_TRY(const uint32_t lone, dropLoneSplats(avatar, assembled->frames, in.jobs()));
    log(LogLevel::Info, "{} splats that stand free of the person in still pictures are left out", lone);
    avatar.captureMap = mapped->capture;
    DPL_TRY([[maybe_unused]] const size_t painted, paintHiddenParts(avatar, chosen->body));
    DPL_TRY(const EvidenceData face, addBodyFace(avatar, chosen->body));
    avatar.evidence.push_back(face);
    DPL_TRY(auto bytes, writeAvatar(avatar, kPackaged));
    std::error_code ignored;
    std::filesystem::remove(checkpoint, ignored);
    return writeFileAtomically(context.folder / "avatar.glb", bytes);
}

Result<Package> StageOf<Package>::read(StageInputs&, const std::filesystem::path& folder) {
    DPL_TRY(auto bytes, readFile(folder / "avatar.glb"));
    return Package{std::move(bytes)};
}

}  // namespace dpl
