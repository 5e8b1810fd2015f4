// SPDX-License-Identifier: Apache-2.0
// The stages observe and ingest. Observe finds missing keypoints, labels and masks in the pictures. Ingest checks the scan.
#include <algorithm>

#include "reconstruction/capture/models_folder.h"
#include "reconstruction/capture/needed_tools.h"
#include "reconstruction/capture/observations.h"
#include "reconstruction/capture/scan_check.h"
#include "reconstruction/capture/validation.h"
#include "reconstruction/pipeline/scan_inputs.h"
#include "reconstruction/pipeline/stages.h"
#include "reconstruction/pipeline/verdict_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

std::string trainingHash(const IngestedScan& ingested) {
    json frames = json::array();
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f)
        if (isTrainingFrame(ingested, f)) frames.push_back(frameInputs(ingested.scan.frames[f], ingested.hashes[f]));
    return hashText(json{{"common", commonInputs(ingested.scan)}, {"frames", frames}}.dump());
}

std::string readText(const std::filesystem::path& path) {
    auto bytes = readFile(path, 64 << 20);
    return bytes ? std::string(bytes->begin(), bytes->end()) : std::string();
}

Error refuseByCheck(const StageRun& run, const IngestedScan& ingested) {
    using nlohmann::ordered_json;
    Refusal refusal{"ingest", ordered_json::array(), ordered_json::parse(ingested.check, nullptr, /*allow_exceptions=*/false)};
    if (refusal.scanCheck.is_object() && refusal.scanCheck.contains("findings"))
        for (const auto& finding : refusal.scanCheck["findings"])
            if (finding.value("severity", "") == "refuse")
                refusal.filmAgain.push_back(
                    {{"topic", finding["topic"]}, {"sentence", finding["sentence"]}, {"frames", finding["frames"]}});
    return refuse(run, refusal, fail(Code::InvalidArgument, "the scan is refused:\n{}", ingested.verdict));
}

/** Refuses a scan for which this machine lacks a tool, before the tools that it has work for minutes. */
Status checkTools(const StageRun& run, const Scan& scan, const std::filesystem::path& folder, const std::filesystem::path& models) {
    ToolNeeds needs = toolNeeds(scan);
    needs.cameras = needs.cameras && !run.chain.hasFinished("cameras");  // an earlier run found them
    const std::vector<std::string> missing = missingTools(needs, models);
    if (missing.empty()) return {};
    return refuse(run, {"ingest"},
                  fail(Code::InvalidArgument,
                       "{}then run the same command again. Or bring keypoints, masks and cameras as files (docs/formats/scan.md)",
                       describeMissing(folder.string(), missing)));
}

/** A scan, with missing observations replaced by what the networks found in its pictures: files in `folder`. */
struct ObservedScan {
    Scan scan;
    std::filesystem::path folder;
};

/** Runs the stage observe. */
Result<ObservedScan> observed(const StageRun& run, const Scan& scan, const std::filesystem::path& models,
                              const std::vector<std::string>& persons) {
    json networks = json::array();
    std::vector<PersonPoint> points;
    for (const std::string& text : persons) {
        DPL_TRY(const PersonPoint point, parsePersonPoint(text));
        points.push_back(point);
    }
    for (const char* name : network_files::kAll)
        if (auto hash = hashFile(models / name)) networks.push_back(*hash);
    const json inputs = {{"scan", scanInputs(scan, hashFrames(scan))}, {"models", networks}, {"persons", persons}};
    DPL_TRY(const StageOutput stage, run.chain.run("observe", 6, inputs, [&](StageContext& context) -> Status {
        ObserveOptions options;
        options.models = models;
        options.output = context.folder;
        options.persons = points;
        options.note = [&](const std::string& text) { context.progress.note(text); };
        options.progress = [&](size_t done, size_t count) {
            context.progress.update(double(done) / double(count), formatText("frame {} of {}", done, count));
        };
        return observeScan(scan, options, run.jobs);
    }));
    return ObservedScan{withObservations(scan, stage.folder), stage.folder};
}

}  // namespace

Result<IngestedScan> runIngest(const StageRun& run, const std::filesystem::path& folder, const std::filesystem::path& models,
                               const std::vector<std::string>& persons, double heightM) {
    IngestedScan ingested;
    auto read = readScan(folder, ScanCameras::MayLack);
    if (!read) return refuse(run, {"ingest"}, read.error());
    ingested.scan = std::move(*read);
    if (heightM > 0) ingested.scan.subjectHeightM = heightM;
    if (!ingested.scan.assumed.empty()) run.progress.note(ingested.scan.assumed);
    DPL_CHECK_OK(checkTools(run, ingested.scan, folder, models));
    std::filesystem::path observations;
    const std::filesystem::path networks = !models.empty() ? models : lacksObservations(ingested.scan) ? installedModels() : models;
    if (!networks.empty()) {
        if (models.empty()) run.progress.note(formatText("networks of {} find what the scan lacks", networks.string()));
        DPL_TRY(ObservedScan seen, observed(run, ingested.scan, networks, persons));
        ingested.scan = std::move(seen.scan), observations = std::move(seen.folder);
    } else if (!persons.empty()) {
        return fail(Code::InvalidArgument,
                    "--person: networks look for nobody in this scan, because it brings keypoints and masks or no network is installed");
    }
    if (!ingested.scan.camerasKnown) {
        DPL_TRY(ingested.scan, runCameras(run, ingested.scan));
        ingested.camerasFound = true;
    } else {
        DPL_TRY(std::optional<Scan> repaired, runCameraRepair(run, ingested.scan));
        ingested.camerasFound = repaired.has_value();
        if (repaired) ingested.scan = std::move(*repaired);
    }
    if (!observations.empty()) {
        DPL_TRY(ingested.scan, runCloseups(run, std::move(ingested.scan), observations));
    }
    const Scan& scan = ingested.scan;
    ingested.hashes = hashFrames(scan);
    DPL_TRY(const StageOutput stage,
            run.chain.run("ingest", 3, {{"scan", scanInputs(scan, ingested.hashes)}}, [&](StageContext& context) -> Status {
                DPL_TRY(ScanCheck check, checkScan(scan, run.jobs, [&](double share) {
                            context.progress.update(share, "reading the pictures");
                            return !context.progress.cancelled();
                        }));
                json usable = json::array();
                for (const FrameCheck& frame : check.frames) usable.push_back(frame.usable);
                DPL_CHECK_OK(writeFileAtomically(context.folder / "check.json", scanCheckJson(scan, check)));
                DPL_CHECK_OK(writeFileAtomically(context.folder / "verdict.txt", describeScanCheck(scan, check)));
                return writeFileAtomically(context.folder / "usable.json",
                                           json{{"usable", usable}, {"refused", check.verdict == ScanVerdict::Refuse}}.dump());
            }));
    ingested.verdict = readText(stage.folder / "verdict.txt");
    ingested.check = readText(stage.folder / "check.json");
    const json usable = json::parse(readText(stage.folder / "usable.json"), nullptr, false);
    if (!usable.is_object() || !usable.contains("usable") || usable["usable"].size() != scan.frames.size())
        return fail(Code::CorruptData, "{} is damaged; delete it and run again", (stage.folder / "usable.json").string());
    ingested.usable = usable["usable"].get<std::vector<bool>>();
    if (usable.value("refused", false)) return refuseByCheck(run, ingested);
    ingested.validation = setValidationAside(ingested.scan, ingested.usable);
    ingested.trainingHash = trainingHash(ingested);
    return ingested;
}

}  // namespace dpl
