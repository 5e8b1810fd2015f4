// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/body/body_tools.h"
#include "reconstruction/body/body_truth.h"
#include "reconstruction/pipeline/fit_file.h"
#include "reconstruction/pipeline/subject_data.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

/** All that the fit reads: keypoints of every frame (held-out poses start from theirs), masks of training frames, cameras. */
Result<json> fitInputs(const SubjectData& subject) {
    json frames = json::array();
    for (const ScanFrame& frame : subject.scan.frames) {
        std::string keypoints = "none";
        if (!frame.keypointsPath.empty()) {
            DPL_TRY(keypoints, hashFile(frame.keypointsPath));
        }
        frames.push_back({frame.name, keypoints});
    }
    DPL_TRY(std::string training, trainingDataHash(subject));
    json inputs{{"frames", frames}, {"training", training}, {"body", subject.bodyHash}};
    if (subject.options.trueBody) {
        DPL_TRY(inputs["truth"], hashFile(subject.options.scan / "truth.json"));
    }
    return inputs;
}

}  // namespace

Status runBodyFit(SubjectData& subject) {
    DPL_TRY(json inputs, fitInputs(subject));
    auto folder = subject.chain.run("body-fit", 2, inputs, [&](StageContext& context) -> Status {
        if (subject.options.trueBody) {
            DPL_TRY(BodyFit truth, fitFromTruth(subject.options.scan, subject.scan, subject.body));
            return writeFileAtomically(context.folder / "fit.json", fitToJson(truth));
        }
        BodyFitSettings settings;
        settings.progress = [&](double fraction, std::string_view what) {
            context.progress.update(fraction, what);
            return !context.progress.cancelled();
        };
        DPL_TRY(BodyFit fit, fitBody(subject.body, subject.scan, settings));
        return writeFileAtomically(context.folder / "fit.json", fitToJson(fit));
    });
    if (!folder) return folder.error();
    DPL_TRY(subject.fit,
            readFitFile(*folder / "fit.json", subject.scan.frames.size(), subject.body.joints.size(), subject.body.morphs.size()));
    subject.shaped = shapedBody(subject.body, subject.fit.shape);
    for (ScanFrame& frame : subject.scan.frames) frame.camera = metricCamera(frame.camera, subject.fit.metresPerUnit);
    return {};
}

}  // namespace dpl
