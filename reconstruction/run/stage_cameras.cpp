// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_cameras.h"

#include <algorithm>

#include "reconstruction/input/cameras/camera_verdict.h"
#include "reconstruction/input/cameras/world_frame.h"
#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/repair_cameras.h"
#include "reconstruction/input/capture/triangulate.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_observe.h"
#include "reconstruction/run/verdict_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

SolveRole roleOf(const ScanFrame& frame) {
    if (frame.split == Split::Test) return SolveRole::HeldOut;
    if (frame.kind == FrameKind::Dynamic) return SolveRole::Moving;
    return frame.kind == FrameKind::StaticCloseup ? SolveRole::Closeup : SolveRole::Still;
}

Result<SolvePixels> loadPixels(const ScanFrame& frame) {
    SolvePixels pixels;
    DPL_TRY(const ImageRgb8 image, readFrameImage(frame));
    pixels.grey.resize(size_t(image.widthPx) * image.heightPx);
    for (size_t i = 0; i < pixels.grey.size(); ++i) {  // Rec. 601 luma
        const uint8_t* p = image.pixels.data() + 3 * i;
        pixels.grey[i] = uint8_t((299 * p[0] + 587 * p[1] + 114 * p[2] + 500) / 1000);
    }
    if (frame.maskPath.empty()) return pixels;
    DPL_TRY(ImageGrey8 mask, readFrameMask(frame));
    pixels.person = std::move(mask.pixels);
    return pixels;
}

/** Triangulates the keypoints of the placed stills. A keypoint that cannot be read is not known. */
StandingPoints standingPoints(const Scan& scan, const SolvedCameras& solved) {
    std::vector<std::vector<Keypoint>> keypoints;
    std::vector<Camerad> cameras;
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        if (roleOf(scan.frames[f]) != SolveRole::Still || !solved.pictures[f].camera) continue;
        ScanFrame frame = scan.frames[f];
        frame.camera = *solved.pictures[f].camera, frame.lens = solved.lens;
        auto read = readKeypoints(scan, frame);
        if (read && !read->empty()) keypoints.push_back(std::move(*read)), cameras.push_back(frame.camera);
    }
    std::vector<KeypointView> views;
    for (size_t i = 0; i < cameras.size(); ++i) views.push_back({cameras[i], &keypoints[i]});
    const auto points = triangulateKeypoints(views, scan.keypointNames.size());
    StandingPoints out;
    const std::pair<const char*, std::optional<Vec3d>*> wanted[] = {
        {"head_top", &out.headTop}, {"shoulder_l", &out.shoulderL}, {"shoulder_r", &out.shoulderR}, {"hip_l", &out.hipL},
        {"hip_r", &out.hipR},       {"ankle_l", &out.ankleL},       {"ankle_r", &out.ankleR}};
    for (size_t k = 0; k < points.size(); ++k)
        for (const auto& [name, place] : wanted)
            if (scan.keypointNames[k] == name) *place = points[k];
    return out;
}

/** Moves everything that was solved into Doppel's world. Returns a sentence about how. */
std::string moveToWorld(const Scan& scan, double heightM, SolvedCameras& solved, FoundCameras& found) {
    std::vector<Camerad> stills;
    for (size_t f = 0; f < scan.frames.size(); ++f)
        if (roleOf(scan.frames[f]) == SolveRole::Still && solved.pictures[f].camera) stills.push_back(*solved.pictures[f].camera);
    const auto world = findWorldFrame({stills, solved.points, standingPoints(scan, solved), heightM});
    if (!world) return "up and scale could not be told from the cameras; the body fit finds the scale";
    for (SolveOutcome& picture : solved.pictures)
        if (picture.camera) picture.camera = moved(*picture.camera, world->worldFromCameras);
    for (Vec3d& point : solved.points) point = world->worldFromCameras(point);
    found.metric = world->metric;
    return formatText("up is {}; {}", world->floorFound ? "the normal of the floor" : "the mean of the cameras' own up",
                      world->metric ? formatText("the scale follows from a height of {} m", heightM)
                      : heightM > 0 ? std::string("the scale is left to the body fit, because no keypoints show head and feet")
                                    : std::string("the scale is left to the body fit; --height METRES would state it"));
}

Status solve(const Scan& scan, double heightM, StageContext& context) {
    std::vector<SolvePicture> pictures;
    for (const ScanFrame& frame : scan.frames) pictures.push_back({frame.name, frame.imagePath, roleOf(frame)});
    SolveSettings settings;
    settings.folder = context.folder;
    settings.widthPx = scan.frames[0].camera.widthPx, settings.heightPx = scan.frames[0].camera.heightPx;
    settings.focalGuessPx = scan.focalGuessPx;
    settings.load = [&](size_t f) { return loadPixels(scan.frames[f]); };
    DPL_TRY(SolvedCameras solved, solveCameras(pictures, settings));

    FoundCameras found;
    found.lens = solved.lens;
    const std::string world = moveToWorld(scan, heightM, solved, found);
    CameraVerdict verdict = judgeCameras(pictures, solved, {0, 1, 0}, {0, 0, 1});
    found.refused = verdict.refuses;
    found.sentences = std::move(verdict.sentences);
    found.gaps = std::move(verdict.gaps);
    if (!found.refused) found.sentences.push_back(world);
    for (size_t f = 0; f < pictures.size(); ++f)
        if (const SolveOutcome& outcome = solved.pictures[f]; outcome.camera)
            found.cameras.push_back({pictures[f].name, *outcome.camera, outcome.missPx, outcome.matches});
    std::error_code ignored;  // pictures and matches are large and can be made again
    for (const char* name : {"images", "masks", "database.db", "pairs.txt"}) std::filesystem::remove_all(context.folder / name, ignored);
    return writeFileAtomically(context.folder / "cameras.json", camerasToJson(found));
}

Result<PlacedScan> placed(const SeenScan& seen, const FoundCameras& found) {
    DPL_TRY(Scan scan, withCameras(seen.scan, found));
    std::vector<FrameHashes> hashes = hashFrames(scan, seen.scan, seen.hashes);
    return PlacedScan{std::move(scan), std::move(hashes), true};
}

}  // namespace

Status StageOf<SolvedScan>::inputs(StageInputs& in) {
    DPL_TRY(const SeenScan* seen, in.part<SeenScan>());
    in.value("scan", scanInputs(seen->scan, seen->hashes));
    in.value("focal", seen->scan.focalGuessPx);
    in.value("height", seen->scan.subjectHeightM);
    return {};
}

Status StageOf<SolvedScan>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const SeenScan* seen, in.of<SeenScan>());
    return solve(seen->scan, seen->scan.subjectHeightM, context);
}

Result<SolvedScan> StageOf<SolvedScan>::read(StageInputs&, const std::filesystem::path& folder) {
    SolvedScan solved;
    DPL_TRY(solved.found, readCamerasFile(folder / "cameras.json"));
    solved.log = folder / "colmap.log";
    return solved;
}

Status StageOf<RepairedScan>::inputs(StageInputs& in) {
    DPL_TRY(const SeenScan* seen, in.part<SeenScan>());
    in.value("scan", scanInputs(seen->scan, seen->hashes));
    in.value("repair", true);
    return {};
}

Status StageOf<RepairedScan>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const SeenScan* seen, in.of<SeenScan>());
    Scan repaired = seen->scan;
    DPL_TRY(const CameraRepair repair, repairCameras(repaired, in.jobs()));
    FoundCameras found;
    found.metric = seen->scan.metricWorld;
    found.sentences = {repair.sentence};
    if (repair.repaired) {
        found.lens = repaired.frames[0].lens;
        for (const ScanFrame& frame : repaired.frames) found.cameras.push_back({frame.name, frame.camera});
    }
    return writeFileAtomically(context.folder / "cameras.json", camerasToJson(found));
}

Result<RepairedScan> StageOf<RepairedScan>::read(StageInputs&, const std::filesystem::path& folder) {
    RepairedScan repaired;
    DPL_TRY(repaired.found, readCamerasFile(folder / "cameras.json"));
    return repaired;
}

Status StageOf<PlacedScan>::inputs(StageInputs& in) {
    DPL_TRY(const SeenScan* seen, in.part<SeenScan>());
    if (!seen->scan.camerasKnown) {
        const Status solved = in.use<SolvedScan>();
        return solved ? Status{} : refuse(in.outFolder(), {"cameras"}, solved.error());
    }
    return keypointsDoubtCameras(seen->scan) ? in.use<RepairedScan>() : Status{};
}

Result<PlacedScan> StageOf<PlacedScan>::compute(StageInputs& in) {
    DPL_TRY(const SeenScan* seen, in.of<SeenScan>());
    if (in.has<RepairedScan>()) {
        DPL_TRY(const RepairedScan* repaired, in.of<RepairedScan>());
        for (const std::string& sentence : repaired->found.sentences) in.progress().note(sentence);
        if (!repaired->found.cameras.empty()) return placed(*seen, repaired->found);
    }
    if (!in.has<SolvedScan>()) return PlacedScan{seen->scan, seen->hashes, false};
    DPL_TRY(const SolvedScan* solved, in.of<SolvedScan>());
    std::string text;
    for (const std::string& sentence : solved->found.sentences) text += (text.empty() ? "" : "\n  ") + sentence;
    if (solved->found.refused) {
        Refusal refusal{"cameras", ordered_json::array()};
        for (const CameraGap& gap : solved->found.gaps)
            refusal.filmAgain.push_back({{"topic", "cameras"}, {"part", gap.part}, {"sentence", gap.sentence}, {"frames", gap.frames}});
        return refuse(in.outFolder(), refusal,
                      fail(Code::InvalidArgument, "the cameras of too few pictures were found:\n  {}\n  COLMAP's log: {}", text,
                           solved->log.string()));
    }
    in.progress().note(text);
    return placed(*seen, solved->found);
}

}  // namespace dpl
