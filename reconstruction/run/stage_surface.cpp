// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_surface.h"

#include <cstring>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/subject/body/landmark_offsets.h"
#include "reconstruction/subject/surface/fit_surface.h"
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

/** Eyes and nose in one picture. Ears, head top and limbs lie below hair, below cloth or within, so that a surface need not follow them. */
Result<std::vector<SurfaceMark>> marksOf(const Scan& scan, size_t row, const FittedBody& body) {
    std::vector<SurfaceMark> marks;
    const ScanFrame& frame = scan.frames[row];
    if (frame.keypointsPath.empty() || !body.fit.fitted[row] || body.fit.swapped[row]) return marks;
    DPL_TRY(const std::vector<Keypoint> seen, readKeypoints(scan, frame));
    for (size_t k = 0; k < scan.keypointNames.size(); ++k) {
        const std::string& name = scan.keypointNames[k];
        if ((name != "nose" && name != "eye_l" && name != "eye_r") || !(seen[k].confidence > 0)) continue;
        const Vec3f seenAt = scan.keypointsFound ? Vec3f(foundLandmarkOffset(name)) : Vec3f(0);
        for (const BodyKeypoint& keypoint : body.shaped.keypoints)
            if (keypoint.name == name && keypoint.joints.empty())
                marks.push_back({keypoint.vertices, seenAt, seen[k].px, float(seen[k].confidence)});
    }
    return marks;
}

}  // namespace

MeshData FittedSurface::clothed(const MeshData& body) const {
    MeshData mesh = body;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) mesh.restPositions[v] += restOffsets[v];
    return mesh;
}

Status StageOf<FittedSurface>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    in.value("training", table->trainingHash);
    in.value("settings", fieldsJson(SurfaceFitSettings()));
    return in.use<FittedBody>();
}

Status StageOf<FittedSurface>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    std::vector<SurfaceView> views;
    for (const size_t row : table->silhouetteRows()) {
        DPL_TRY(const auto picture, table->picture(row));
        DPL_TRY(auto marks, marksOf(table->scan, row, *body));
        views.push_back({metric->cameras[row], picture->mask, body->poses[row], std::move(marks)});
    }
    if (views.empty())
        return fail(Code::InvalidArgument, "no still training frame has a mask; add masks, or let networks find the person: {}",
                    howToGetNetworks());
    DPL_TRY(SurfaceFit surface, fitSurface(body->shaped.mesh, body->shaped.joints, views, {}, in.jobs()));
    const nlohmann::json info = {{"mean_iou_before", surface.meanIouBefore},
                                 {"mean_iou_after", surface.meanIouAfter},
                                 {"mean_offset_m", surface.meanOffsetM},
                                 {"largest_offset_m", surface.largestOffsetM}};
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "surface.json", info.dump(1)));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "sway.bin", bytesOf(surface.viewTranslationsM)));
    return writeFileAtomically(context.folder / "offsets.bin", bytesOf(surface.restOffsets));
}

Result<FittedSurface> StageOf<FittedSurface>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    FittedSurface surface;
    DPL_TRY(surface.restOffsets, readVectors(folder / "offsets.bin", body->shaped.mesh.restPositions.size()));
    surface.poses.poses = body->poses.poses;
    const std::vector<size_t> rows = table->silhouetteRows();
    DPL_TRY(const std::vector<Vec3f> sway, readVectors(folder / "sway.bin", rows.size()));
    for (size_t i = 0; i < rows.size(); ++i) surface.poses[rows[i]].rootTranslation += sway[i];
    return surface;
}

}  // namespace dpl
