// SPDX-License-Identifier: Apache-2.0
// The stage garments: makes the layers of the clothed subject from the fitted body, masks and labels of the still training frames.
#include <algorithm>

#include "reconstruction/run/clothed_file.h"
#include "reconstruction/run/stages.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

Status dress(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface, Pictures& pictures,
             const std::vector<ScanLabel>& labels, StageContext& context) {
    std::vector<GarmentView> views;
    for (size_t f : silhouetteFrames(ingested)) {
        DPL_TRY(const auto picture, pictures.of(f));
        views.push_back({body.cameras[f], picture->mask, picture->labels, surface.poses[f]});
    }
    std::vector<GarmentView> moving;
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f) {
        const ScanFrame& frame = ingested.scan.frames[f];
        if (!isTrainingFrame(ingested, f) || frame.kind != FrameKind::Dynamic || frame.maskPath.empty() || frame.labelsPath.empty())
            continue;
        DPL_TRY(const auto picture, pictures.of(f));
        moving.push_back({body.cameras[f], picture->mask, picture->labels, body.fit.poses[f]});
    }
    const auto progress = [&](double fraction) {
        context.progress.update(fraction, formatText("{} still pictures", views.size()));
        return !context.progress.cancelled();
    };
    const GarmentInput input{body.shaped.mesh, body.shaped.joints, surface.restOffsets, views, moving, labels};
    DPL_TRY(const GarmentFit fit, makeClothedMesh(input, progress, run.jobs));
    json decisions = json::array();
    for (const GarmentDecision& d : fit.decisions)
        decisions.push_back(
            {{"part", d.label.name}, {"kept", d.kept}, {"reason", d.reason}, {"triangles", d.triangles}, {"areaM2", d.areaM2}});
    json legs = json::array();
    for (const LegDecision& d : fit.legs)
        legs.push_back({{"part", d.name}, {"parted", d.seen.parted()}, {"cloth_pixels", d.seen.cloth}, {"free_pixels", d.seen.free}});
    const json info = {{"summary", fit.summary},  {"decisions", decisions},        {"legs", legs},
                       {"hull_iou", fit.hullIou}, {"inside_body", fit.insideBody}, {"largest_weight_step", fit.largestWeightStep}};
    DPL_CHECK_OK(writeFileAtomically(context.folder / "garments.json", info.dump(1)));
    context.progress.note(fit.summary);
    return writeClothedFile(fit.clothed, context.folder / "clothed.bin");
}

/** One row a label: whether it became a layer, and why. */
Result<std::vector<EvidenceData>> readDecisions(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path));
    const json info = json::parse(bytes.begin(), bytes.end(), nullptr, /*allow_exceptions=*/false);
    const auto damaged = [&] { return fail(Code::CorruptData, "{} is damaged; delete it and run again", path.string()); };
    if (!info.is_object() || !info.contains("decisions") || !info["decisions"].is_array() || !info.contains("summary") ||
        !info["summary"].is_string())
        return damaged();
    std::vector<EvidenceData> rows;
    for (const json& d : info["decisions"]) {
        if (!d.is_object() || !d.contains("part") || !d["part"].is_string() || !d.contains("kept") || !d["kept"].is_boolean() ||
            !d.contains("reason") || !d["reason"].is_string())
            return damaged();
        rows.push_back({"garment layer: " + d["part"].get<std::string>(), d["kept"].get<bool>(), 0, 0, d["reason"].get<std::string>()});
    }
    if (rows.empty()) rows.push_back({"garment layers", false, 0, 0, info["summary"].get<std::string>()});
    return rows;
}

}  // namespace

Result<DressedBody> runGarments(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                                Pictures& pictures, const RunSettings& settings) {
    // Layers are carved out of still silhouettes.
    const auto still = [](const ScanFrame& frame) { return frame.kind == FrameKind::StaticFull; };
    const bool anyStill = std::any_of(ingested.scan.frames.begin(), ingested.scan.frames.end(), still);
    const std::vector<ScanLabel> wanted = settings.layers && anyStill ? ingested.scan.labels : std::vector<ScanLabel>{};
    json labels = json::array();
    for (const ScanLabel& label : wanted) labels.push_back({label.name, label.value});
    const json inputs = {{"training", ingested.trainingHash}, {"surface", surface.key}, {"labels", labels}};
    DPL_TRY(const StageOutput stage, run.chain.run("garments", 9, inputs, [&](StageContext& context) {
        return dress(run, ingested, body, surface, pictures, wanted, context);
    }));
    DressedBody dressed;
    dressed.key = stage.key;
    DPL_TRY(dressed.clothed, readClothedFile(stage.folder / "clothed.bin", body.shaped.joints.size()));
    DPL_TRY(dressed.decided, readDecisions(stage.folder / "garments.json"));
    if (!settings.layers)
        dressed.decided = {{"garment layers", false, 0, 0, "left out by --without layers"}};
    else if (!anyStill)
        dressed.decided = {{"garment layers", false, 0, 0, "no still full-body picture, and layers are cut from those"}};
    return dressed;
}

}  // namespace dpl
