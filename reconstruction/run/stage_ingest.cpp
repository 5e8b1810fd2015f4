// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_ingest.h"

#include "reconstruction/input/capture/scan_check.h"
#include "reconstruction/input/capture/validation.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_closeups.h"
#include "reconstruction/run/stage_observe.h"
#include "reconstruction/run/verdict_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

std::string trainingHash(const FrameTable& table) {
    json frames = json::array();
    for (size_t row = 0; row < table.rows(); ++row)
        if (table.trains(row)) frames.push_back(frameInputs(table.scan.frames[row], table.hashes[row]));
    return hashText(json{{"common", commonInputs(table.scan)}, {"frames", frames}}.dump());
}

std::string readText(const std::filesystem::path& path) {
    auto bytes = readFile(path, 64 << 20);
    return bytes ? std::string(bytes->begin(), bytes->end()) : std::string();
}

Error refuseByCheck(const std::filesystem::path& out, const CheckedScan& checked) {
    using nlohmann::ordered_json;
    Refusal refusal{"ingest", ordered_json::array(), ordered_json::parse(checked.check, nullptr, /*allow_exceptions=*/false)};
    if (refusal.scanCheck.is_object() && refusal.scanCheck.contains("findings"))
        for (const auto& finding : refusal.scanCheck["findings"])
            if (finding.value("severity", "") == "refuse")
                refusal.filmAgain.push_back(
                    {{"topic", finding["topic"]}, {"sentence", finding["sentence"]}, {"frames", finding["frames"]}});
    return refuse(out, refusal, fail(Code::InvalidArgument, "the scan is refused:\n{}", checked.verdict));
}

}  // namespace

Status StageOf<CheckedScan>::inputs(StageInputs& in) {
    DPL_TRY(const CompleteScan* complete, in.part<CompleteScan>());
    in.value("scan", scanInputs(complete->scan, complete->hashes));
    return {};
}

Status StageOf<CheckedScan>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const CompleteScan* complete, in.of<CompleteScan>());
    const Scan& scan = complete->scan;
    DPL_TRY(ScanCheck check, checkScan(scan, in.jobs()));
    json usable = json::array();
    for (const FrameCheck& frame : check.frames) usable.push_back(frame.usable);
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "check.json", scanCheckJson(scan, check)));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "verdict.txt", describeScanCheck(scan, check)));
    return writeFileAtomically(context.folder / "usable.json",
                               json{{"usable", usable}, {"refused", check.verdict == ScanVerdict::Refuse}}.dump());
}

Result<CheckedScan> StageOf<CheckedScan>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const CompleteScan* complete, in.of<CompleteScan>());
    CheckedScan checked{readText(folder / "verdict.txt"), readText(folder / "check.json"), {}, false};
    const json usable = json::parse(readText(folder / "usable.json"), nullptr, false);
    if (!usable.is_object() || !usable.contains("usable") || usable["usable"].size() != complete->scan.frames.size())
        return fail(Code::CorruptData, "{} is damaged; delete it and run again", (folder / "usable.json").string());
    checked.usable = usable["usable"].get<std::vector<bool>>();
    checked.refused = usable.value("refused", false);
    return checked;
}

Status StageOf<FrameTable>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const ReadScan* read, in.part<ReadScan>());
    DPL_TRY([[maybe_unused]] const CompleteScan* complete, in.part<CompleteScan>());
    return in.use<CheckedScan>();
}

Result<FrameTable> StageOf<FrameTable>::compute(StageInputs& in) {
    DPL_TRY(const CompleteScan* complete, in.of<CompleteScan>());
    DPL_TRY(const CheckedScan* checked, in.of<CheckedScan>());
    if (checked->refused) return refuseByCheck(in.outFolder(), *checked);
    DPL_TRY(const ReadScan* read, in.of<ReadScan>());
    FrameTable table;
    table.scanHash = read->hash;
    table.scan = complete->scan;
    table.camerasFound = complete->camerasFound;
    table.usable = checked->usable;
    table.hashes = complete->hashes;
    table.verdict = checked->verdict;
    table.check = checked->check;
    table.validation = setValidationAside(table.scan, table.usable);
    table.trainingHash = trainingHash(table);
    in.progress().detail(formatText("decoded pictures are kept up to {} MiB", PictureCache::kBoundBytes >> 20));
    return table;
}

}  // namespace dpl
