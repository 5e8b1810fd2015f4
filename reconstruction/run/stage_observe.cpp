// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_observe.h"

#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/capture/needed_tools.h"
#include "reconstruction/input/observe/observations.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_cameras.h"
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

namespace {

/** Refuses a scan for which this machine lacks a tool, before the tools that it has work for minutes. */
Status checkTools(StageInputs& in, const Scan& scan, const RunRequest& request) {
    ToolNeeds needs = toolNeeds(scan);
    needs.cameras = needs.cameras && !in.hasFinished(StageOf<SolvedScan>::kName.name);  // an earlier run found them
    const std::vector<std::string> missing = missingTools(needs, request.options.models);
    if (missing.empty()) return {};
    return refuse(in.outFolder(), {"ingest"},
                  fail(Code::InvalidArgument,
                       "{}then run the same command again. Or bring keypoints, masks and cameras as files (docs/formats/scan.md)",
                       describeMissing(request.scan.string(), missing)));
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
    ReadScan out{std::move(*read), {}, {}, options.models};
    out.hashes = hashFrames(out.scan);
    out.hash = hashOfScan(out.scan, out.hashes);
    if (options.heightM > 0) out.scan.subjectHeightM = options.heightM;
    if (!out.scan.assumed.empty()) in.progress().note(out.scan.assumed);
    DPL_RETURN_IF_ERROR(checkTools(in, out.scan, *request));
    if (out.networks.empty() && lacksObservations(out.scan)) {
        out.networks = installedModels();
        if (!out.networks.empty()) in.progress().note(formatText("networks of {} find what the scan lacks", out.networks.string()));
    }
    if (out.networks.empty() && !options.persons.empty())
        return fail(Code::InvalidArgument,
                    "--person: networks look for nobody in this scan, because it brings keypoints and masks or no network is installed");
    return out;
}

Status StageOf<Observations>::inputs(StageInputs& in) {
    DPL_TRY(const RunRequest* request, in.part<RunRequest>());
    DPL_TRY(const ReadScan* read, in.part<ReadScan>());
    DPL_TRY([[maybe_unused]] const auto points, personPoints(request->options));
    json networks = json::array();
    for (const char* name : network_files::kAll)
        if (auto hash = hashFile(read->networks / name)) networks.push_back(*hash);
    in.value("scan", scanInputs(read->scan, read->hashes));
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
    return observeScan(read->scan, options, in.jobs());
}

Result<Observations> StageOf<Observations>::read(StageInputs&, const std::filesystem::path& folder) {
    return Observations{folder};
}

Status StageOf<SeenScan>::inputs(StageInputs& in) {
    DPL_TRY(const ReadScan* read, in.part<ReadScan>());
    return read->networks.empty() ? Status{} : in.use<Observations>();
}

Result<SeenScan> StageOf<SeenScan>::compute(StageInputs& in) {
    DPL_TRY(const ReadScan* read, in.of<ReadScan>());
    if (!in.has<Observations>()) return SeenScan{read->scan, read->hashes, {}};
    DPL_TRY(const Observations* observations, in.of<Observations>());
    Scan scan = withObservations(read->scan, observations->folder);
    std::vector<FrameHashes> hashes = hashFrames(scan, read->scan, read->hashes);
    return SeenScan{std::move(scan), std::move(hashes), observations->folder};
}

}  // namespace dpl
