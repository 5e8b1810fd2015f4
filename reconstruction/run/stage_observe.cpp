// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_observe.h"

#include <algorithm>

#include "reconstruction/input/observe/models_folder.h"
#include "reconstruction/input/observe/observations.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/verdict_file.h"

namespace dpl {

using nlohmann::json;

namespace {

Result<std::vector<PersonPoint>> personPoints(const ReconstructOptions& options) {
    std::vector<PersonPoint> points;
    for (const std::string& text : options.persons) {
        DPL_TRY(const PersonPoint point, parsePersonPoint(text));
        points.push_back(point);
    }
    return points;
}

}  // namespace

Status StageOf<ReadScan>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const RunRequest* request, in.part<RunRequest>());
    return {};
}

Result<ReadScan> StageOf<ReadScan>::compute(StageInputs& in) {
    DPL_TRY(const RunRequest* request, in.of<RunRequest>());
    const ReconstructOptions& options = request->options;
    auto read = readScan(request->scan, ScanCameras::MayLack);
    if (!read) return refuse(in.outFolder(), {"ingest"}, read.error());
    ReadScan out{std::move(*read), {}, options.models};
    out.hash = hashOfScan(out.scan, hashFrames(out.scan));
    if (options.heightM > 0) out.scan.subjectHeightM = options.heightM;
    if (!out.scan.assumed.empty()) in.progress().note(out.scan.assumed);
    if (out.networks.empty() && lacksObservations(out.scan)) {
        out.networks = installedModels();
        if (!out.networks.empty()) in.progress().note(formatText("networks of {} find what the scan lacks", out.networks.string()));
    }
    if (out.networks.empty() && !options.persons.empty())
        return fail(Code::InvalidArgument,
                    "--person: networks look for nobody in this scan; it brings keypoints and masks, or tools/models "
                    "has not run");
    return out;
}

Status StageOf<Observations>::inputs(StageInputs& in) {
    DPL_TRY(const RunRequest* request, in.part<RunRequest>());
    DPL_TRY(const ReadScan* read, in.part<ReadScan>());
    DPL_TRY([[maybe_unused]] const auto points, personPoints(request->options));
    json networks = json::array();
    for (const char* name : network_files::kAll)
        if (auto hash = hashFile(read->networks / name)) networks.push_back(*hash);
    in.value("scan", scanInputs(read->scan, hashFrames(read->scan)));
    in.value("models", networks);
    in.value("persons", request->options.persons);
    return {};
}

Status StageOf<Observations>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const RunRequest* request, in.of<RunRequest>());
    DPL_TRY(const ReadScan* read, in.of<ReadScan>());
    ObserveOptions options;
    options.models = read->networks;
    options.output = context.folder;
    DPL_TRY(options.persons, personPoints(request->options));
    options.note = [&](const std::string& text) { context.progress.note(text); };
    options.progress = [&](size_t done, size_t count) {
        context.progress.update(double(done) / double(count), formatText("frame {} of {}", done, count));
    };
    return observeScan(read->scan, options, in.jobs());
}

Result<Observations> StageOf<Observations>::read(StageInputs&, const std::filesystem::path& folder) {
    return Observations{folder};
}

Status StageOf<SeenScan>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const RunRequest* request, in.part<RunRequest>());
    DPL_TRY(const ReadScan* read, in.part<ReadScan>());
    return read->networks.empty() ? Status{} : in.use<Observations>();
}

Result<SeenScan> StageOf<SeenScan>::compute(StageInputs& in) {
    DPL_TRY(const RunRequest* request, in.of<RunRequest>());
    DPL_TRY(const ReadScan* read, in.of<ReadScan>());
    SeenScan seen{read->scan, {}};
    if (in.has<Observations>()) {
        DPL_TRY(const Observations* observations, in.of<Observations>());
        seen = {withObservations(read->scan, observations->folder), observations->folder};
    }
    // Before cameras are sought, which takes minutes.
    for (const auto& [what, path] : {std::pair("keypoints", &ScanFrame::keypointsPath), std::pair("masks", &ScanFrame::maskPath)})
        if (std::all_of(seen.scan.frames.begin(), seen.scan.frames.end(),
                        [path = path](const ScanFrame& frame) { return (frame.*path).empty(); }))
            return refuse(in.outFolder(), {"ingest"},
                          fail(Code::InvalidArgument,
                               "{} brings no {}: run tools/models once, which fetches networks that find them, or add {} files "
                               "(docs/formats/scan.md)",
                               request->scan.string(), what, what));
    return seen;
}

}  // namespace dpl
