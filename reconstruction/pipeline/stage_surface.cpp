// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "reconstruction/capture/models_folder.h"
#include "reconstruction/pipeline/stage_keys.h"
#include "reconstruction/pipeline/stages.h"
#include "reconstruction/surface/fit_surface.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

std::span<const uint8_t> bytesOf(const std::vector<Vec3f>& values) {
    return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(Vec3f)};
}

Result<std::vector<Vec3f>> readVectors(const std::filesystem::path& path, size_t count) {
    DPL_TRY(auto bytes, readFile(path));
    if (bytes.size() != count * sizeof(Vec3f))
        return fail(Code::CorruptData, "{} does not fit the body and the scan; delete it and run again", path.string());
    std::vector<Vec3f> values(count);
    std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    return values;
}

Status fit(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, Pictures& pictures, SurfaceFitSettings settings,
           StageContext& context) {
    std::vector<SurfaceView> views;
    for (size_t f : silhouetteFrames(ingested)) {
        DPL_TRY(const auto picture, pictures.of(f));
        views.push_back({body.cameras[f], picture->mask, body.fit.poses[f]});
    }
    if (views.empty())
        return fail(Code::InvalidArgument, "no still training frame has a mask; add masks, or let networks find the person: {}",
                    howToGetNetworks());
    settings.progress = [&](double fraction) {
        context.progress.update(fraction, formatText("{} silhouettes", views.size()));
        return !context.progress.cancelled();
    };
    DPL_TRY(SurfaceFit surface, fitSurface(body.shaped.mesh, body.shaped.joints, views, settings, run.jobs));
    const nlohmann::json info = {{"mean_iou_before", surface.meanIouBefore},
                                 {"mean_iou_after", surface.meanIouAfter},
                                 {"mean_offset_m", surface.meanOffsetM},
                                 {"largest_offset_m", surface.largestOffsetM}};
    DPL_CHECK_OK(writeFileAtomically(context.folder / "surface.json", info.dump(1)));
    DPL_CHECK_OK(writeFileAtomically(context.folder / "sway.bin", bytesOf(surface.viewTranslationsM)));
    return writeFileAtomically(context.folder / "offsets.bin", bytesOf(surface.restOffsets));
}

}  // namespace

Result<FittedSurface> runSurface(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, Pictures& pictures) {
    const SurfaceFitSettings settings;
    const nlohmann::json inputs = {{"training", ingested.trainingHash}, {"body_fit", body.key}, {"settings", fieldsJson(settings)}};
    DPL_TRY(const StageOutput stage, run.chain.run("surface", 1, inputs, [&](StageContext& context) {
        return fit(run, ingested, body, pictures, settings, context);
    }));
    FittedSurface surface;
    surface.key = stage.key;
    DPL_TRY(surface.restOffsets, readVectors(stage.folder / "offsets.bin", body.shaped.mesh.restPositions.size()));
    surface.poses = body.fit.poses;
    const std::vector<size_t> frames = silhouetteFrames(ingested);
    DPL_TRY(const std::vector<Vec3f> sway, readVectors(stage.folder / "sway.bin", frames.size()));
    for (size_t i = 0; i < frames.size(); ++i) surface.poses[frames[i]].rootTranslation += sway[i];
    return surface;
}

}  // namespace dpl
