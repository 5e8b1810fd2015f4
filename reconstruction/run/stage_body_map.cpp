// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_body_map.h"

#include "reconstruction/judging/coach/joint_map.h"
#include "reconstruction/judging/coach/map_pictures.h"
#include "reconstruction/judging/coach/moves.h"
#include "reconstruction/judging/coach/shots.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_surface.h"
#include "sdk/core/files.h"
#include "sdk/format/capture_map.h"

namespace dpl {
namespace {

using nlohmann::ordered_json;

constexpr const char* kPictureFiles[] = {"pixel.png", "pictures.png", "blur.png"};

ordered_json figuresJson(const FilmAgain& advice) {
    ordered_json out{{"film_again", ordered_json::array()}, {"places", ordered_json::array()}};
    for (const Shot& shot : advice.shots)
        out["film_again"].push_back({{"shot", shot.key}, {"sentence", shot.sentence}, {"gain", shot.gain}});
    for (const PlaceFigures& p : advice.places)
        out["places"].push_back({{"place", wordsOf(p.place).key},
                                 {"name", wordsOf(p.place).name},
                                 {"mm_per_pixel", 1000 * p.pixelM},
                                 {"finest_detail_mm", 1000 * p.detailM},
                                 {"blur_px", p.blurPx},
                                 {"pictures", p.views},
                                 {"not_seen", p.unseenShare}});
    return out;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> shotsOf(const MappedBody& mapped) {
    std::vector<std::pair<std::string, std::string>> shots;
    for (const auto& shot : mapped.figures["film_again"]) shots.emplace_back(shot.value("shot", ""), shot.value("sentence", ""));
    return shots;
}

Status StageOf<MappedBody>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    DPL_TRY([[maybe_unused]] const FittedBody* body, in.part<FittedBody>());
    in.value("training", table->trainingHash);
    return in.use<FittedSurface>();
}

Status StageOf<MappedBody>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const FittedSurface* surface, in.of<FittedSurface>());
    const MeshData mesh = surface->clothed(body->shaped.mesh);
    std::vector<PosedPicture> stills;
    std::vector<Pose> moving;
    for (size_t row = 0; row < table->rows(); ++row) {
        const FrameKind kind = table->scan.frames[row].kind;
        if (!table->trains(row)) continue;
        if (kind == FrameKind::Dynamic) {
            moving.push_back(surface->poses[row]);
            continue;
        }
        stills.push_back({table->lazyPicture(row), metric->cameras[row], surface->poses[row], kind == FrameKind::StaticCloseup});
    }
    const std::vector<JointData>& joints = body->shaped.joints;
    const std::vector<BodyPlace> places = placesOf(joints, mesh);
    DPL_TRY(const std::vector<SeenTriangle> map, mapBody(mesh, joints, stills, in.jobs()));
    FilmAgain advice = bestShots(mesh, joints, places, map, stills, in.jobs());
    if (auto moves = movesToFilm(joints, moving)) advice.shots.push_back(std::move(*moves));
    const CaptureMapData capture = captureMapOf(mesh, joints.size(), map, advice.viewable);
    DPL_RETURN_IF_ERROR(checkCaptureMap(capture, joints.size()));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "capture_map.bin", encodeCaptureMap(capture)));
    DPL_TRY(const std::vector<MapPicture> drawn, drawMap(mesh, map));
    for (size_t i = 0; i < drawn.size(); ++i) DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / kPictureFiles[i], drawn[i].png));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "map.json", figuresJson(advice).dump(1)));
    return writeFileAtomically(context.folder / "film_again.txt", describeShots(advice));
}

Result<MappedBody> StageOf<MappedBody>::read(StageInputs& in, const std::filesystem::path& folder) {
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    MappedBody mapped;
    DPL_TRY(const auto text, readFile(folder / "film_again.txt"));
    mapped.advice.assign(text.begin(), text.end());
    DPL_TRY(const auto figures, readFile(folder / "map.json"));
    mapped.figures = ordered_json::parse(figures.begin(), figures.end(), nullptr, /*allow_exceptions=*/false);
    if (!mapped.figures.is_object() || !mapped.figures.contains("places") || !mapped.figures.contains("film_again"))
        return fail(Code::CorruptData, "{} is damaged; delete it and run again", (folder / "map.json").string());
    DPL_TRY(const auto capture, readFile(folder / "capture_map.bin"));
    DPL_TRY(mapped.capture, decodeCaptureMap(capture, body->shaped.joints.size()));
    for (const char* file : kPictureFiles) {
        DPL_TRY(mapped.pictures.emplace_back(), readFile(folder / file));
    }
    return mapped;
}

}  // namespace dpl
