// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reconstruction/judging/ladder/ladder.h"
#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/error_map.h"
#include "reconstruction/judging/report/plain_words.h"
#include "reconstruction/judging/report/provenance.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/run/detail_figures.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/frame_scores.h"
#include "reconstruction/run/label_figures.h"
#include "reconstruction/run/live_person.h"
#include "reconstruction/run/needle_figures.h"
#include "reconstruction/run/portrait.h"
#include "reconstruction/run/report_pictures.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/scale_figures.h"
#include "reconstruction/run/settings_json.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_body_map.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_package.h"
#include "reconstruction/run/stage_pose_fit.h"
#include "reconstruction/subject/body/body_truth.h"
#include "reconstruction/training/correctives/corrective_strain.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/files.h"
#include "sdk/core/percentile.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

constexpr double kGarmentRatio = 0.75;  // bar: distance of a garment from the truth, of that under plain LBS

/** Adds the distances of joints to the truth of a synthetic scan, with the bars for registration. */
void addTruth(const TruthComparison& truth, const std::string& key, const std::string& after, ReportData& data) {
    const std::string group = "registration against the truth, held-out dynamic frames, " + after;
    const auto add = [&](const char* part, const char* name, const char* unit, double value, double atMost) {
        data.figures.push_back({"truth." + key + "." + part, group, name, unit, value, ReportBar{atMost, /*atLeast=*/false}});
    };
    add("keypoints_mean", "keypoints, mean", "mm", truth.keypointsMm.mean, 15);
    add("keypoints_p95", "keypoints, 95th percentile", "mm", truth.keypointsMm.p95, 40);
    add("limbs_median", "limb directions, median", "degrees", truth.limbDegrees.median, 3);
    add("limbs_p95", "limb directions, 95th percentile", "degrees", truth.limbDegrees.p95, 10);
}

/** Adds how far fingertips are from the truth as their wrist sees them, beside what fingers at rest would be. */
void addFingers(const FingerTruth& truth, const std::string& key, const std::string& after, ReportData& data) {
    const std::string group = "fingertips in the wrist's frame against the truth, " + after;
    const auto add = [&](const char* part, const char* name, const ErrorSpread& found, const ErrorSpread& atRest, double atMost) {
        if (found.count == 0) return;
        data.figures.push_back({"truth." + key + "." + part, group, name, "mm", found.mean,
                                ReportBar{std::min(atMost, 0.5 * atRest.mean), /*atLeast=*/false}});
        data.figures.push_back(
            {"truth." + key + "." + part + "_at_rest", group, std::string(name) + ", fingers never fitted", "mm", atRest.mean, {}});
    };
    add("fingers_still", "still frames, mean", truth.stillMm, truth.stillAtRestMm, 8);
    add("fingers_moving", "moving frames, mean", truth.movingMm, truth.movingAtRestMm, 15);
}

/** Adds the keypoint residuals, the distances to the truth if the scan has one, and what the figures stand for. The avatar is already
 *  written, so the truth cannot affect it. */
void addRegistration(const Scan& scan, const FittedBody& body, const PosesFile& poses, ReportData& data) {
    for (const KindResidual& r : body.fit.residuals) {
        const std::string group = std::string("keypoint residual, ") + shortKindName(r.kind) +
                                  (r.split == Split::Test         ? ", held out"
                                   : r.split == Split::Validation ? ", validation"
                                                                  : ", training");
        const std::string key = formatText("residual.{}.{}", shortKindName(r.kind), splitName(r.split));
        data.figures.push_back({key + ".median", group, "median", "px", r.medianPx, {}});
        data.figures.push_back({key + ".p95", group, "95th percentile", "px", r.p95Px, {}});
    }
    const std::string noise = "detector noise in the still training frames";
    if (body.fit.keypointSigma > 0) {
        data.figures.push_back(
            {"detector.sigma", noise, "standard deviation at full confidence", "% of the diagonal", 100 * body.fit.keypointSigma, {}});
        data.figures.push_back(
            {"detector.assumed_sigma", noise, "the same, assumed by the body fit", "% of the diagonal", 100 * keypointSigma(scan), {}});
        data.figures.push_back({"detector.outliers", noise, "outliers", "% of the keypoints", 100 * body.fit.outlierShare, {}});
    }
    for (const HandFit& hand : body.hands) {
        const std::string group = "fingers from keypoints", key = hand.left ? "hand.left" : "hand.right";
        const std::string name = hand.left ? "left hand" : "right hand";
        data.figures.push_back({key + ".still",
                                group,
                                name + ", still frames that show it; fingers " + (hand.turned ? "turned" : "at rest"),
                                "frames",
                                double(hand.stillFrames),
                                {}});
        data.figures.push_back({key + ".moving", group, name + ", moving frames that show it", "frames", double(hand.movingFrames), {}});
        data.figures.push_back(
            {key + ".posed", group, name + ", of these with fingers of their own", "frames", double(hand.posedFrames), {}});
        data.figures.push_back({key + ".median", group, name + ", keypoints from the fitted fingers, median", "px", hand.medianPx, {}});
    }
    const auto afterFit = compareWithTruth(scan.root, scan, body.shaped, body.fit);
    data.provenance = provenanceOf(scan.name, afterFit && afterFit->sameBody);
    if (!afterFit || afterFit->keypointsMm.count == 0) return;
    addTruth(*afterFit, "body_fit", "after the body fit", data);
    addFingers(afterFit->fingers, "body_fit", "after the body fit", data);
    BodyFit final = body.fit;
    for (size_t f = 0; f < final.poses.size(); ++f) final.poses[f] = poses.frames[f].bestPose();
    if (const auto afterPoseFit = compareWithTruth(scan.root, scan, body.shaped, final)) {
        addTruth(*afterPoseFit, "pose_fit", "after training and pose fit", data);
        addFingers(afterPoseFit->fingers, "pose_fit", "after training and pose fit", data);
    }
}

/** Adds how far training put the roots of still frames from the pose that they share: sway, and what cameras err. Cameras and focal lengths
 * are not refined by themselves, since a root's turn and shift and the person's size take up their errors (docs/reference/cameras.md). */
void addCameraErrors(const FittedBody& body, const PosesFile& poses, ReportData& data) {
    std::vector<double> shiftMm, turnDegrees;
    for (const FramePose& frame : poses.frames) {
        if (frame.kind != FrameKind::StaticFull || frame.split != Split::Train) continue;
        const Pose &still = body.fit.staticPose, &own = frame.pose;
        const double cosine = std::abs(double(glm::dot(still.localRotations[0], own.localRotations[0])));
        shiftMm.push_back(1000 * double(glm::length(own.rootTranslation - still.rootTranslation)));
        turnDegrees.push_back(glm::degrees(2 * std::acos(std::min(1.0, cosine))));
    }
    if (shiftMm.empty()) return;
    const std::string group = "cameras are not refined: what roots of still frames took up, sway and camera errors";
    data.figures.push_back({"cameras.root_shift", group, "shift from the shared pose, median", "mm", percentile(shiftMm, 0.5), {}});
    data.figures.push_back({"cameras.root_turn", group, "turn from the shared pose, median", "degrees", percentile(turnDegrees, 0.5), {}});
}

/** Adds the gain of pose fit and of splats, the two steps that the report measures both with and without. */
void addWaterfall(ReportData& data) {
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        const auto with = meanScore(data.frames, kind, &HeldOutFrame::withPoseFit),
                   without = meanScore(data.frames, kind, &HeldOutFrame::withoutPoseFit);
        const auto mesh = meanScore(data.frames, kind, &HeldOutFrame::meshFloor);
        if (!with) continue;
        const std::string name = shortKindName(kind);
        const auto add = [&](const char* part, const char* what, double gainDb) {
            data.waterfall.push_back({name + "." + part, name, what, "dB", gainDb, {}});
        };
        add("pose_fit", "registration of held-out frames (pose fit on against off)", with->maskedPsnrDb - without->maskedPsnrDb);
        add("splats", "splats over the same mesh with vertex colours", with->maskedPsnrDb - mesh->maskedPsnrDb);
    }
}

/** Adds how far each simulated garment is from the truth on held-out moving frames in true poses, against plain LBS. */
void addGarments(ReportData& data) {
    if (!data.ladder) return;
    for (const GarmentRow& row : data.ladder->garments)
        for (size_t g = 0; g < row.cells.size(); ++g) {
            const LadderGroup& group = data.ladder->groups[g];
            const GarmentCell& cell = row.cells[g];
            if (row.poses != GarmentPoses::True || group.kind != FrameKind::Dynamic || group.split != Split::Test || !(cell.plainMm > 0))
                continue;
            const std::string heading = "garments against the truth, held-out dynamic frames, true poses", key = "garment." + row.garment;
            data.figures.push_back({key + ".distance", heading, row.garment + ", distance", "mm", cell.correctedMm, {}});
            data.figures.push_back({key + ".distance_ratio", heading, row.garment + ", distance over that under plain LBS", "",
                                    cell.correctedMm / cell.plainMm, ReportBar{kGarmentRatio, /*atLeast=*/false}});
            data.figures.push_back(
                {key + ".point_distance", heading, row.garment + ", distance of points", "mm", cell.pointCorrectedMm, {}});
            if (cell.pointPlainMm > 0)
                data.figures.push_back({key + ".point_distance_ratio",
                                        heading,
                                        row.garment + ", distance of points over that under plain LBS",
                                        "",
                                        cell.pointCorrectedMm / cell.pointPlainMm,
                                        {}});
        }
}

/** Adds what the best smooth light gains at the true surface, by its window. Still frames lack no light, so their gain is overfit. */
void addLight(ReportData& data) {
    if (!data.ladder) return;
    const auto rungOf = [&](const std::string& key) {
        return std::find_if(data.ladder->rungs.begin(), data.ladder->rungs.end(), [&](const LadderRung& rung) { return rung.key == key; });
    };
    const auto plain = rungOf("true_surface");
    if (plain == data.ladder->rungs.end()) return;
    constexpr std::pair<const char*, const char*> kWindows[] = {{"", "4"}, {"_fine", "1.2"}, {"_finest", "0.8"}};
    for (const auto& [part, percent] : kWindows) {
        const auto lit = rungOf(std::string("true_surface_light") + part);
        for (size_t g = 0; g < data.ladder->groups.size(); ++g) {
            const LadderGroup& group = data.ladder->groups[g];
            if (group.split != Split::Test || lit == data.ladder->rungs.end() || lit->cells[g].frames == 0) continue;
            data.figures.push_back({formatText("light.{}{}", shortKindName(group.kind), part),
                                    "best smooth light at the true surface, held-out frames",
                                    formatText("gain in a window of {} % of the height, {}", percent,
                                               group.kind == FrameKind::Dynamic ? "dynamic" : "static (control: overfit)"),
                                    "dB",
                                    lit->cells[g].maskedPsnrDb - plain->cells[g].maskedPsnrDb,
                                    {}});
        }
    }
}

FilmAgainSection filmAgainSection(const FrameTable& table, const MappedBody& mapped) {
    FilmAgainSection section{mapped.advice, {}, {}, {}, mapped.pictures};
    const auto check = nlohmann::json::parse(table.check, nullptr, /*allow_exceptions=*/false);
    if (check.is_object() && check.contains("findings"))
        for (const auto& finding : check["findings"]) section.warnings.push_back(finding.value("sentence", ""));
    for (const auto& p : mapped.figures["places"])
        section.rows.push_back({p.value("place", ""), p.value("name", ""), p.value("mm_per_pixel", 0.0), p.value("finest_detail_mm", 0.0),
                                p.value("blur_px", 0.0), p.value("pictures", 0.0), p.value("not_seen", 0.0)});
    return section;
}

/** What it is worth, for who filmed. */
std::string wordsOf(const ReportData& data) {
    std::string text = verdictSentence(data);
    if (const std::string draft = draftSentence(data); !draft.empty()) text += "\n" + draft;
    return text;
}

/** What was measured, for engineers. */
std::string summaryOf(const ReportData& data, size_t splats, size_t bytes) {
    std::string text = formatText("{} splats, {} bytes", splats, bytes);
    text += scoreLines(data.frames, "held-out") + scoreLines(data.validation, "validation");
    if (const std::string bars = barSummary(data); !bars.empty()) text += "\n" + bars;
    for (const std::string& sentence : data.provenance) text += "\n" + sentence;
    return text;
}

/** Hashes of the labels of frames that were not trained on: the floors and the figures of fine detail read them. */
nlohmann::json scoredLabels(const FrameTable& table) {
    nlohmann::json out = nlohmann::json::array();
    for (size_t row = 0; row < table.rows(); ++row)
        if (table.scan.frames[row].split != Split::Train) out.push_back({table.scan.frames[row].name, table.hashes[row].labels});
    return out;
}

/** Hashes of the files that the report reads itself: the truth with its surfaces, what scan.json says of them, and pictures at other sizes.
 */
nlohmann::json measuringFiles(const std::filesystem::path& scan) {
    namespace fs = std::filesystem;
    std::vector<fs::path> files{scan / "truth.json", scan / "scan.json"};
    std::error_code error;
    for (const char* folder : {"hires", "geometry", "posed"})
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(scan / folder, error)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    nlohmann::json hashes = nlohmann::json::array();
    for (const fs::path& file : files) {
        if (!fs::is_regular_file(file, error)) continue;
        if (const auto hash = hashFile(file)) hashes.push_back({file.lexically_relative(scan).string(), *hash});
    }
    return hashes;
}

}  // namespace

Status StageOf<ReportFiles>::inputs(StageInputs& in) {
    DPL_TRY(const FrameTable* table, in.part<FrameTable>());
    DPL_TRY([[maybe_unused]] const MetricCameras* cameras, in.part<MetricCameras>());
    DPL_TRY([[maybe_unused]] const FittedBody* body, in.part<FittedBody>());
    DPL_TRY([[maybe_unused]] const Training* training, in.part<Training>());
    DPL_TRY([[maybe_unused]] const SettingsAfterTraining* after, in.part<SettingsAfterTraining>());
    DPL_TRY([[maybe_unused]] const Package* package, in.part<Package>());
    in.value("scan", table->scanHash);
    in.value("labels", scoredLabels(*table));
    in.value("verdict", table->verdict + table->validation);
    in.value("measuring", measuringFiles(table->scan.root));
    DPL_TRY(const RunRequest* request, in.part<RunRequest>());
    in.value("web", livePageKey(request->options.web));
    DPL_RETURN_IF_ERROR(in.use<MappedBody>());
    return in.use<FoundPoses>();
}

Status StageOf<ReportFiles>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    DPL_TRY(const MetricCameras* metric, in.of<MetricCameras>());
    DPL_TRY(const FittedBody* body, in.of<FittedBody>());
    DPL_TRY(const Training* training, in.of<Training>());
    DPL_TRY(const SettingsAfterTraining* after, in.of<SettingsAfterTraining>());
    DPL_TRY(const MappedBody* mapped, in.of<MappedBody>());
    DPL_TRY(const Package* package, in.of<Package>());
    DPL_TRY(const FoundPoses* read, in.of<FoundPoses>());
    DPL_TRY(const RunRequest* request, in.of<RunRequest>());
    const RunSettings& settings = after->settings;
    DPL_TRY(AvatarData avatar, readAvatar(package->bytes));
    PosesFile found = read->poses;
    rememberPoses(table->scan, avatar.correctives.motion, found);
    DPL_TRY(AvatarInfo info, inspectAvatar(package->bytes));
    ReportData data;
    data.title = "Doppel: " + table->scan.name;
    data.avatarFile = "avatar.glb";
    data.facts = {{"scan", table->scan.root.filename().string() + ", " + table->scanHash},
                  {"body", body->shaped.name},
                  {"training", formatText("{} steps, at most {} splats; polish {} steps, pose fit {}",
                                          training->result.curve.empty() ? 0u : training->result.curve.back().step,
                                          settings.training.maxSplats, settings.polishSteps, settings.poseFit.iterations)},
                  {"seed", std::to_string(settings.training.seed)},
                  {"splats", std::to_string(avatar.splats.count())},
                  {"file", std::to_string(package->bytes.size()) + " bytes"},
                  {"avatar", info.contentHash}};
    data.filmAgain = filmAgainSection(*table, *mapped);
    data.verdict = table->verdict + table->validation + "\n";
    data.length = {training->steps, settingsOf({}).training.steps};
    DPL_TRY(auto view, AvatarView::open(package->bytes, in.jobs().threadCount()));
    DPL_TRY(data.portrait, drawPortrait(table->scan, metric->cameras, found, avatar, view, in.jobs()));
    DPL_RETURN_IF_ERROR(bringToLife(request->options.web, package->bytes, avatar, data));
    const FilmedAvatar filmed{*table, metric->cameras, found, avatar};
    DPL_TRY(data.filmAgain.cards, drawAdvice(filmed, view, shotsOf(*mapped)));
    DPL_TRY(data.clips, drawClips(filmed, view));
    DPL_TRY(const LabelColours labelColours, gatherLabelColours(*table));
    const std::vector<Pose> poses = found.poses();
    const FrameSet heldOut = table->frames(Split::Test, metric->cameras, poses);
    DPL_TRY(data.frames, scoreFrames(labelColours, heldOut, avatar, view, found, true, in.jobs()));
    DPL_TRY(data.errorMap, drawErrorMap(avatar.mesh, data.frames));
    const FrameSet validation = table->frames(Split::Validation, metric->cameras, poses);
    DPL_TRY(data.validation, scoreFrames(labelColours, validation, avatar, view, found, false, in.jobs()));
    DPL_TRY(data.ladder, measureLadder({table->scan, metric->cameras, avatar, found}, in.jobs()));
    DPL_RETURN_IF_ERROR(addScaleFigures(table->scan.root, view, heldOut, found, data));
    DPL_RETURN_IF_ERROR(addDetailFigures(table->scan, view, heldOut, found, data));
    DPL_RETURN_IF_ERROR(addLabelFigures(table->scan, view, heldOut, found, data));
    DPL_RETURN_IF_ERROR(addBarFigures(table->scan, view, heldOut, found, data));
    for (const StageRecord& s : in.records()) data.stages.push_back({s.name, s.seconds, s.peakBytes, s.reused});
    PlotSeries loss{"total", {}, {}}, psnr{"masked", {}, {}};
    for (const CurvePoint& p : training->result.curve) {
        loss.x.push_back(p.step), loss.y.push_back(p.loss);
        psnr.x.push_back(p.step), psnr.y.push_back(p.psnr);
    }
    data.lossCurves = {loss};
    data.psnrCurves = {psnr};
    addRegistration(table->scan, *body, found, data);
    addCameraErrors(*body, found, data);
    const StepProfile& profile = training->result.profile;
    const auto add = [&data](const char* key, const std::string& group, const char* name, const char* unit, double value) {
        data.figures.push_back({key, group, name, unit, value, {}});
    };
    const std::string speed = "training step, mean over the last epoch";
    add("training_step.ms", speed, "step", "ms", profile.stepMs);
    add("training_step.pairs", speed, "pixel-splat pairs", "a step", profile.pairs);
    add("training_step.forward_ns", speed, "forward", "ns a pair", profile.forwardNsPerPair);
    add("training_step.backward_ns", speed, "backward", "ns a pair", profile.backwardNsPerPair);
    if (const CorrectiveStrain stress = correctiveStrain(avatar, in.jobs()); stress.offsetMm > 0) {
        const std::string strange = "pose correctives on 64 random poses that nobody trained, 99th percentiles";
        add("correctives.offset", strange, "offset", "mm", stress.offsetMm);
        add("correctives.strain", strange, "strain of an edge", "%", stress.strainPercent);
        add("correctives.light", strange, "change of brightness", "%", stress.lightPercent);
    }
    addNeedleFigures(avatar, in.jobs(), data);
    const std::string size = "avatar file";
    add("file.bytes_a_splat", size, "splats and SH", "bytes a splat", double(info.splatBytes + info.shBytes) / std::max(1u, info.splats));
    add("file.bytes", size, "whole file", "bytes", double(package->bytes.size()));
    addWaterfall(data);
    addGarments(data);
    addLight(data);
    data.evidence = avatar.evidence;
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "summary.txt", summaryOf(data, avatar.splats.count(), package->bytes.size())));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "words.txt", wordsOf(data)));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "word.txt", std::string(wordOf(worthOf(data)))));
    DPL_RETURN_IF_ERROR(writeFileAtomically(context.folder / "portrait.jpg", data.portrait.small));
    return writeReport(data, context.folder);
}

Result<ReportFiles> StageOf<ReportFiles>::read(StageInputs&, const std::filesystem::path& folder) {
    ReportFiles files{folder, {}, {}, {}};
    for (const auto& [name, text] : {std::pair{"summary.txt", &files.summary}, {"words.txt", &files.words}, {"word.txt", &files.word}}) {
        DPL_TRY(const auto bytes, readFile(folder / name));
        text->assign(bytes.begin(), bytes.end());
    }
    return files;
}

}  // namespace dpl
