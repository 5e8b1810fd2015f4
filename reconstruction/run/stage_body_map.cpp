// SPDX-License-Identifier: Apache-2.0
// The stage body-map: how the still training pictures show the fitted surface, and what to film again.
#include "reconstruction/judging/coach/joint_map.h"
#include "reconstruction/judging/coach/map_pictures.h"
#include "reconstruction/judging/coach/shots.h"
#include "reconstruction/run/stages.h"
#include "sdk/core/files.h"
#include "sdk/format/capture_map.h"

namespace dpl {
namespace {

using nlohmann::json;
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

Status mapSurface(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                  Pictures& pictures, StageContext& context) {
    MeshData mesh = body.shaped.mesh;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) mesh.restPositions[v] += surface.restOffsets[v];
    std::vector<std::shared_ptr<const FramePicture>> kept;
    std::vector<PosedPicture> stills;
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f) {
        const ScanFrame& frame = ingested.scan.frames[f];
        if (frame.kind == FrameKind::Dynamic || !isTrainingFrame(ingested, f)) continue;
        DPL_TRY(kept.emplace_back(), pictures.of(f));
        stills.push_back({*kept.back(), body.cameras[f], surface.poses[f], frame.kind == FrameKind::StaticCloseup});
    }
    const std::vector<JointData>& joints = body.shaped.joints;
    const std::vector<BodyPlace> places = placesOf(joints, mesh);
    const auto tell = [&](double share) {
        context.progress.update(0.8 * share, formatText("{} still pictures", stills.size()));
        return !context.progress.cancelled();
    };
    DPL_TRY(const std::vector<SeenTriangle> map, mapBody(mesh, joints, stills, tell, run.jobs));
    const FilmAgain advice = bestShots(mesh, joints, places, map, stills, run.jobs);
    const CaptureMapData capture = captureMapOf(mesh, joints.size(), map, advice.viewable);
    DPL_CHECK_OK(checkCaptureMap(capture, joints.size()));
    DPL_CHECK_OK(writeFileAtomically(context.folder / "capture_map.bin", encodeCaptureMap(capture)));
    DPL_TRY(const std::vector<MapPicture> drawn, drawMap(mesh, map));
    for (size_t i = 0; i < drawn.size(); ++i) DPL_CHECK_OK(writeFileAtomically(context.folder / kPictureFiles[i], drawn[i].png));
    DPL_CHECK_OK(writeFileAtomically(context.folder / "map.json", figuresJson(advice).dump(1)));
    return writeFileAtomically(context.folder / "film_again.txt", describeShots(advice));
}

}  // namespace

Result<MappedBody> runBodyMap(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                              Pictures& pictures) {
    const json inputs = {{"training", ingested.trainingHash}, {"surface", surface.key}};
    DPL_TRY(const StageOutput stage, run.chain.run("body-map", 3, inputs, [&](StageContext& context) {
        return mapSurface(run, ingested, body, surface, pictures, context);
    }));
    MappedBody mapped;
    mapped.key = stage.key;
    DPL_TRY(const auto text, readFile(stage.folder / "film_again.txt"));
    mapped.advice.assign(text.begin(), text.end());
    DPL_TRY(const auto figures, readFile(stage.folder / "map.json"));
    mapped.figures = ordered_json::parse(figures.begin(), figures.end(), nullptr, /*allow_exceptions=*/false);
    if (!mapped.figures.is_object() || !mapped.figures.contains("places") || !mapped.figures.contains("film_again"))
        return fail(Code::CorruptData, "{} is damaged; delete it and run again", (stage.folder / "map.json").string());
    DPL_TRY(const auto capture, readFile(stage.folder / "capture_map.bin"));
    DPL_TRY(mapped.capture, decodeCaptureMap(capture, body.shaped.joints.size()));
    for (const char* file : kPictureFiles) {
        DPL_TRY(mapped.pictures.emplace_back(), readFile(stage.folder / file));
    }
    return mapped;
}

}  // namespace dpl
