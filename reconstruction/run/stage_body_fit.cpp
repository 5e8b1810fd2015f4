// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "reconstruction/run/fit_file.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_keys.h"
#include "reconstruction/run/stages.h"
#include "reconstruction/subject/body/body_io.h"
#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/rest_shoulders.h"
#include "reconstruction/subject/body/swapped_sides.h"
#include "reconstruction/subject/sample/builtin_body.h"
#include "sdk/core/files.h"

namespace dpl {

Result<ChosenBody> chooseBody(const std::filesystem::path& file, Jobs& jobs) {
    ChosenBody chosen;
    if (file.empty()) {
        chosen.body = withBoneMorphs(makeBuiltinBody(jobs));
    } else {
        DPL_TRY(chosen.body, readBody(file));
    }
    if (Status checked = checkBody(chosen.body); !checked)
        return fail(checked.error().code, "{}: {}", file.empty() ? "the built-in body" : file.string(), checked.error().message);
    DPL_TRY(auto bytes, encodeBody(chosen.body));
    chosen.hash = hashBytes(bytes);
    return chosen;
}

Result<FittedBody> readFittedBody(const StageOutput& stage, const IngestedScan& ingested, const BodyModel& body) {
    FittedBody fitted;
    fitted.key = stage.key;
    DPL_TRY(fitted.fit, readFitFile(stage.folder / "fit.json", ingested.scan.frames.size(), body.joints.size(), body.morphs.size()));
    fitted.shaped = shapedBody(body, fitted.fit.shape);
    restShouldersAsScanned(fitted.shaped, fitted.fit);
    for (const ScanFrame& frame : ingested.scan.frames) fitted.cameras.push_back(metricCamera(frame.camera, fitted.fit.metresPerUnit));
    return fitted;
}

Result<FittedBody> runBodyFit(const StageRun& run, const IngestedScan& ingested, const ChosenBody& chosen) {
    BodyFitSettings settings;
    // The fit reads the keypoints of every frame and the masks of training frames. Poses of other frames start from their keypoints, and
    // the stages after it draw them with their cameras.
    nlohmann::json inputs = {{"posed", posedInputs(ingested.scan, ingested.hashes)},
                             {"keypoint_sigma", keypointSigma(ingested.scan)},
                             {"training", ingested.trainingHash},
                             {"body", chosen.hash},
                             {"settings", fieldsJson(settings)}};
    if (!ingested.scan.metricWorld && ingested.scan.subjectHeightM > 0) inputs["height"] = ingested.scan.subjectHeightM;
    DPL_TRY(const StageOutput stage, run.chain.run("body-fit", 12, inputs, [&](StageContext& context) -> Status {
        settings.progress = [&](double fraction, std::string_view what) {
            context.progress.update(fraction, what);
            return !context.progress.cancelled();
        };
        DPL_TRY(BodyFit fit, fitBody(chosen.body, ingested.scan, settings));
        if (const std::string swaps = describeSwaps(ingested.scan, fit.swapped); !swaps.empty()) context.progress.note(swaps);
        if (fit.metresPerUnit != 1)
            context.progress.note(formatText("one unit of the scan's world is {} m, by the size of the person in it",
                                             std::round(1000 * fit.metresPerUnit) / 1000));
        else if (!ingested.scan.unitStated)
            context.progress.note("the scan's world is taken to be in metres: the person in it is of a human size");
        return writeFileAtomically(context.folder / "fit.json", fitToJson(fit));
    }));
    return readFittedBody(stage, ingested, chosen.body);
}

}  // namespace dpl
