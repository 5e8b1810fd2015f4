// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_garments.h"

#include <algorithm>

#include "reconstruction/run/clothed_file.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_surface.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

/** Layers are carved out of still silhouettes. */
bool anyStill(const Scan& scan) {
    return std::any_of(scan.frames.begin(), scan.frames.end(), [](const ScanFrame& frame) { return frame.kind == FrameKind::StaticFull; });
}

std::vector<ScanLabel> wantedLabels(const Scan& scan, const RunSettings& settings) {
    return settings.layers && anyStill(scan) ? scan.labels : std::vector<ScanLabel>{};
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

Status StageOf<GarmentLayers>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY(const RunSettings* settings, in.part<RunSettings>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    DPL_TRY([[maybe_unused]] const FittedBody* body, in.part<FittedBody>());
    json labels = json::array();
    for (const ScanLabel& label : wantedLabels(table->scan, *settings)) labels.push_back({label.name, label.value});
    in.value("training", table->trainingHash);
    in.value("labels", labels);
    return in.use<FittedSurface>();
}

Status StageOf<GarmentLayers>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const FittedSurface* surface, in.of<FittedSurface>());
    std::vector<GarmentView> views;
    for (const size_t row : table->silhouetteRows()) {
        DPL_TRY(const auto picture, table->picture(row));
        views.push_back({metric->cameras[row], picture->mask, picture->labels, surface->poses[row]});
    }
    std::vector<GarmentView> moving;
    for (size_t row = 0; row < table->rows(); ++row) {
        const ScanFrame& frame = table->scan.frames[row];
        if (!table->trains(row) || frame.kind != FrameKind::Dynamic || frame.maskPath.empty() || frame.labelsPath.empty()) continue;
        DPL_TRY(const auto picture, table->picture(row));
        moving.push_back({metric->cameras[row], picture->mask, picture->labels, body->poses[row]});
    }
    const std::vector<ScanLabel> labels = wantedLabels(table->scan, *settings);
    const GarmentInput input{body->shaped.mesh, body->shaped.joints, surface->restOffsets, views, moving, labels};
    DPL_TRY(const GarmentFit fit, makeClothedMesh(input, in.jobs()));
    json decisions = json::array();
    for (const GarmentDecision& d : fit.decisions)
        decisions.push_back(
            {{"part", d.label.name}, {"kept", d.kept}, {"reason", d.reason}, {"triangles", d.triangles}, {"areaM2", d.areaM2}});
    json legs = json::array();
    for (const LegDecision& d : fit.legs)
        legs.push_back({{"part", d.name}, {"parted", d.seen.parted()}, {"cloth_pixels", d.seen.cloth}, {"free_pixels", d.seen.free}});
    const json info = {{"summary", fit.summary},  {"decisions", decisions},        {"legs", legs},
                       {"hull_iou", fit.hullIou}, {"inside_body", fit.insideBody}, {"largest_weight_step", fit.largestWeightStep}};
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "garments.json", info.dump(1)));
    context.progress.note(fit.summary);
    return writeClothedFile(fit.clothed, context.folder / "clothed.bin");
}

Result<GarmentLayers> StageOf<GarmentLayers>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const RunSettings* settings, in.of<RunSettings>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    GarmentLayers layers;
    DPL_TRY(layers.clothed, readClothedFile(folder / "clothed.bin", body->shaped.joints.size()));
    DPL_TRY(layers.decided, readDecisions(folder / "garments.json"));
    if (!settings->layers)
        layers.decided = {{"garment layers", false, 0, 0, "left out by --without layers"}};
    else if (!anyStill(table->scan))
        layers.decided = {{"garment layers", false, 0, 0, "no still full-body picture, and layers are cut from those"}};
    return layers;
}

}  // namespace dpl
