// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_body_fit.h"

#include <cmath>

#include "reconstruction/run/fit_file.h"
#include "reconstruction/run/precision_file.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/subject/body/body_io.h"
#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/rest_shoulders.h"
#include "reconstruction/subject/body/swapped_sides.h"
#include "reconstruction/subject/sample/builtin_body.h"
#include "sdk/core/files.h"

namespace dpl {

Status StageOf<ChosenBody>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const RunRequest* request, in.part<RunRequest>());
    return {};
}

Result<ChosenBody> StageOf<ChosenBody>::compute(StageInputs& in) {
    DPL_TRY(const RunRequest* request, in.of<RunRequest>());
    const std::filesystem::path& file = request->options.body;
    ChosenBody chosen;
    if (file.empty()) {
        chosen.body = withBoneMorphs(makeBuiltinBody(in.jobs()));
    } else {
        DPL_TRY(chosen.body, readBody(file));
    }
    if (Status checked = checkBody(chosen.body); !checked)
        return fail(checked.error().code, "{}: {}", file.empty() ? "the built-in body" : file.string(), checked.error().message);
    DPL_TRY(const auto whole, encodeBody(chosen.body));
    chosen.faceHash = hashBytes(whole);
    std::vector<ExpressionShape> expressions;
    std::swap(expressions, chosen.body.expressions);
    DPL_TRY(const auto still, encodeBody(chosen.body));
    chosen.hash = hashBytes(still);
    std::swap(expressions, chosen.body.expressions);
    return chosen;
}

namespace {

/** What both hands say of the fingers of each frame; of the root alone, and nothing of it, where neither does. */
std::vector<PosePrecision> ofBothHands(std::span<const HandFit> hands, size_t frameCount) {
    std::vector<PosePrecision> out(frameCount, PosePrecision{{0}, std::vector<double>(36, 0.0)});
    for (const HandFit& hand : hands)
        for (size_t f = 0; f < frameCount; ++f)
            if (hand.precisions[f]) out[f] = together(out[f], *hand.precisions[f]);
    return out;
}

}  // namespace

FittedBody fittedBody(const BodyModel& body, BodyFit fit) {
    FittedBody fitted;
    fitted.fit = std::move(fit);
    fitted.shaped = shapedBody(body, fitted.fit.shape);
    restShouldersAsScanned(fitted.shaped, fitted.fit);
    fitted.poses.poses = fitted.fit.poses;
    return fitted;
}

Status StageOf<FittedBody>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY(const ChosenBody* chosen, in.part<ChosenBody>());
    // The fit reads the keypoints of every frame and the masks of training frames. Poses of other frames start from their keypoints, and
    // the stages after it draw them with their cameras.
    in.value("posed", posedInputs(table->scan, table->hashes));
    in.value("keypoint_sigma", keypointSigma(table->scan));
    in.value("training", table->trainingHash);
    in.value("body", chosen->hash);
    in.value("settings", fieldsJson(BodyFitSettings()));
    if (!table->scan.metricWorld && table->scan.subjectHeightM > 0) in.value("height", table->scan.subjectHeightM);
    return {};
}

Status StageOf<FittedBody>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const ChosenBody* chosen, in.of<ChosenBody>());
    const Scan& scan = table->scan;
    BodyFitSettings settings;
    BodyFit fit;
    {
        const TaskPart body(0, 0.9);
        DPL_TRY(fit, fitBody(chosen->body, scan, settings, in.jobs().threadCount()));
    }
    std::vector<HandFit> hands;
    {
        const TaskPart fingers(0.9, 1);
        DPL_TRY(hands, fitFingers(chosen->body, scan, fit));
    }
    if (const std::string swaps = describeSwaps(scan, fit.swapped); !swaps.empty()) context.progress.note(swaps);
    if (fit.metresPerUnit != 1)
        context.progress.note(formatText("one unit of the scan's world is {} m, by the size of the person in it",
                                         std::round(1000 * fit.metresPerUnit) / 1000));
    else if (!scan.unitStated)
        context.progress.note("the scan's world is taken to be in metres: the person in it is of a human size");
    for (const HandFit& hand : hands) context.progress.note(describeHand(hand));
    if (!hands.empty()) {
        DPL_RETURN_IF_ERROR(writePrecisions(ofBothHands(hands, scan.frames.size()), context.folder / "fingers.bin"));
        DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "hands.json", handsToJson(hands)));
    }
    return writeFileAtomically(context.folder / "fit.json", fitToJson(fit));
}

Result<FittedBody> StageOf<FittedBody>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const ChosenBody* chosen, in.of<ChosenBody>());
    DPL_TRY(BodyFit fit, readFitFile(folder / "fit.json", table->rows(), chosen->body.joints.size(), chosen->body.morphs.size()));
    FittedBody fitted = fittedBody(chosen->body, std::move(fit));
    std::error_code ignored;
    if (std::filesystem::exists(folder / "hands.json", ignored)) {
        DPL_TRY(fitted.hands, readHandsFile(folder / "hands.json"));
        DPL_TRY(fitted.fingers, readPrecisions(folder / "fingers.bin", table->rows(), chosen->body.joints.size()));
    }
    return fitted;
}

Status StageOf<MetricCameras>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const FittedBody* body, in.part<FittedBody>());
    return {};
}

Result<MetricCameras> StageOf<MetricCameras>::compute(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    MetricCameras out;
    for (const ScanFrame& frame : table->scan.frames) out.cameras.push_back(metricCamera(frame.camera, body->fit.metresPerUnit));
    return out;
}

}  // namespace dpl
