// SPDX-License-Identifier: Apache-2.0
// report: scores the shipped bytes, through the public SDK, on the frames that nothing before has seen.
#include <nlohmann/json.hpp>

#include "reconstruction/body/body_truth.h"
#include "reconstruction/distill/pose_stress.h"
#include "reconstruction/image/image_codec.h"
#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/scale_figures.h"
#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/pipeline/trained_file.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/report.h"
#include "reconstruction/report/score.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

Status scoreHeldOut(const SubjectData& subject, StageContext& context, const AvatarData& avatar, AvatarView& view,
                    std::span<const TrainFrame> frames, std::span<const size_t> indices, const PosesFile& poses, ReportData& data) {
    LabelColours labelColours;
    {
        DPL_TRY(auto training, loadTrainFrames(subject, Split::Train));
        for (const TrainFrame& frame : training)
            if (frame.kind != FrameKind::StaticCloseup) labelColours.add(frame.image, frame.mask, frame.labels);
    }
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    PosedMesh posed;
    for (size_t i = 0; i < frames.size(); ++i) {
        if (context.progress.cancelled()) return fail(Code::Cancelled, "stopped");
        const TrainFrame& frame = frames[i];
        const FramePose& found = poses.frames[indices[i]];
        const Pose& fitted = found.fittedPose ? *found.fittedPose : found.pose;
        HeldOutFrame out;
        out.name = frame.name;
        out.kind = frame.kind == FrameKind::Dynamic ? "dynamic" : "static";
        DPL_TRY(auto plain, view.draw(found.pose, frame.camera));
        DPL_TRY(auto best, view.draw(fitted, frame.camera));
        out.withoutPoseFit = scorePicture(plain, frame.image, frame.mask);
        out.withPoseFit = scorePicture(best, frame.image, frame.mask);
        out.labelFloor = scorePicture(labelColours.paint(frame.mask, frame.labels), frame.image, frame.mask);
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, fitted, subject.jobs);
        out.meshFloor =
            scorePicture(paintMesh(posed.positions(), avatar.mesh.triangles, avatar.mesh.colours, frame.camera), frame.image, frame.mask);
        const auto truth = overWhite(cutOut(frame.image, frame.mask)), shown = overWhite(best);
        const uint32_t w = frame.camera.widthPx, h = frame.camera.heightPx;
        DPL_TRY(out.truthPng, encodePng(truth, w, h, 3));
        DPL_TRY(out.renderPng, encodePng(shown, w, h, 3));
        DPL_TRY(out.differencePng, encodePng(differenceTimesFour(shown, truth), w, h, 3));
        data.frames.push_back(std::move(out));
        context.progress.update(double(i + 1) / double(frames.size()), frame.name);
    }
    return {};
}

/** Places against the truth of a synthetic scan, if it has one. */
void addTruth(const SubjectData& subject, const BodyFit& fit, const std::string& after, ReportData& data) {
    const auto truth = compareWithTruth(subject.options.scan, subject.scan, subject.body, fit);
    if (!truth) return;
    const std::string group = "registration against the truth, held-out dynamic frames, " + after;
    data.figures.push_back({group, "keypoints, mean", "mm", truth->keypointsMm.mean});
    data.figures.push_back({group, "keypoints, 95th percentile", "mm", truth->keypointsMm.p95});
    data.figures.push_back({group, "limb directions, median", "degrees", truth->limbDegrees.median});
    data.figures.push_back({group, "limb directions, 95th percentile", "degrees", truth->limbDegrees.p95});
}

void addRegistration(const SubjectData& subject, const PosesFile& poses, ReportData& data) {
    for (const KindResidual& r : subject.fit.residuals) {
        const std::string kind = r.kind == FrameKind::Dynamic ? "dynamic" : r.kind == FrameKind::StaticFull ? "static" : "close-up";
        const std::string group = "keypoint residual, " + kind + (r.split == Split::Test ? ", held out" : ", training");
        data.figures.push_back({group, "median", "px", r.medianPx});
        data.figures.push_back({group, "95th percentile", "px", r.p95Px});
    }
    // Measuring only: everything that ships is written before this is read.
    addTruth(subject, subject.fit, "after the body fit", data);
    BodyFit final = subject.fit;
    for (size_t f = 0; f < final.poses.size(); ++f)
        final.poses[f] = poses.frames[f].fittedPose ? *poses.frames[f].fittedPose : poses.frames[f].pose;
    addTruth(subject, final, "after training and pose fit", data);
}

/** What the report can attribute: the two steps that it measures with and without. */
void addWaterfall(ReportData& data) {
    for (const char* kind : {"static", "dynamic"}) {
        const auto with = meanScore(data.frames, kind, &HeldOutFrame::withPoseFit),
                   without = meanScore(data.frames, kind, &HeldOutFrame::withoutPoseFit);
        const auto mesh = meanScore(data.frames, kind, &HeldOutFrame::meshFloor);
        if (!with) continue;
        data.waterfall.push_back(
            {kind, "registration of held-out frames (pose fit on against off)", "dB", with->maskedPsnrDb - without->maskedPsnrDb});
        data.waterfall.push_back({kind, "splats over the same mesh with vertex colours", "dB", with->maskedPsnrDb - mesh->maskedPsnrDb});
    }
}

std::string summaryOf(const ReportData& data, size_t splats, size_t bytes) {
    std::string text = formatText("{} splats, {} bytes", splats, bytes);
    for (const char* kind : {"static", "dynamic"})
        if (auto mean = meanScore(data.frames, kind, &HeldOutFrame::withPoseFit)) {
            char line[160];
            std::snprintf(line, sizeof line,
                          "\nheld-out %-7s  masked PSNR %.2f dB, alpha IoU %.4f, SSIM %.4f (pose fitted; without: %.2f dB)", kind,
                          mean->maskedPsnrDb, mean->alphaIou, mean->maskedSsim,
                          meanScore(data.frames, kind, &HeldOutFrame::withoutPoseFit)->maskedPsnrDb);
            text += line;
        }
    return text;
}

Status report(SubjectData& subject, StageContext& context) {
    DPL_TRY(auto bytes, readFile(subject.packageFolder / "avatar.glb"));
    DPL_TRY(AvatarData avatar, readAvatar(bytes));
    DPL_TRY(AvatarInfo info, inspectAvatar(bytes));
    DPL_TRY(PosesFile poses, readPosesFile(subject.poseFitFolder / "poses.json"));
    DPL_TRY(CoOptimiseResult trained, readTrainedFile(subject.trainedFolder / "trained.bin", subject.shaped.mesh.triangles.size(),
                                                      subject.shaped.mesh.restPositions.size(), subject.shaped.joints.size()));
    ReportData data;
    data.title = "Doppel: " + subject.scan.name;
    const char* presets[] = {"draft", "standard", "high"};
    data.facts = {{"scan", subject.options.scan.filename().string()},
                  {"body", subject.body.name + (subject.options.trueBody ? " (shape and poses from truth.json)" : "")},
                  {"preset", presets[size_t(subject.options.preset)]},
                  {"seed", std::to_string(subject.options.seed)},
                  {"splats", std::to_string(avatar.splats.count())},
                  {"file", std::to_string(bytes.size()) + " bytes"},
                  {"content hash", info.contentHash}};
    data.verdict = subject.verdict;
    DPL_TRY(auto view, AvatarView::open(bytes, subject.options.threadCount));
    std::vector<size_t> indices;
    DPL_TRY(auto heldOut, loadTrainFrames(subject, Split::Test, &indices));
    DPL_CHECK_OK(scoreHeldOut(subject, context, avatar, view, heldOut, indices, poses, data));
    DPL_CHECK_OK(addScaleFigures(subject.options.scan, context.progress, view, heldOut, indices, poses, data));
    for (const StageRecord& s : subject.chain.records()) data.stages.push_back({s.name, s.seconds, s.peakBytes, s.reused});
    PlotSeries loss{"total", {}, {}}, psnr{"masked", {}, {}};
    for (const CurvePoint& p : trained.curve) {
        loss.x.push_back(p.step), loss.y.push_back(p.loss);
        psnr.x.push_back(p.step), psnr.y.push_back(p.psnr);
    }
    data.lossCurves = {loss};
    data.psnrCurves = {psnr};
    addRegistration(subject, poses, data);
    const std::string speed = "training step, mean over the last epoch";
    data.figures.push_back({speed, "step", "ms", trained.profile.stepMs});
    data.figures.push_back({speed, "pixel-splat pairs", "a step", trained.profile.pairs});
    data.figures.push_back({speed, "forward", "ns a pair", trained.profile.forwardNsPerPair});
    data.figures.push_back({speed, "backward", "ns a pair", trained.profile.backwardNsPerPair});
    if (const PoseStress stress = poseStress(avatar, subject.jobs); stress.offsetMm > 0) {
        const std::string strange = "pose correctives on 64 random poses that nobody trained, 99th percentiles";
        data.figures.push_back({strange, "offset", "mm", stress.offsetMm});
        data.figures.push_back({strange, "strain of an edge", "%", stress.strainPercent});
        data.figures.push_back({strange, "change of brightness", "%", stress.lightPercent});
    }
    const std::string size = "avatar file";
    data.figures.push_back({size, "splats and SH", "bytes a splat", double(info.splatBytes + info.shBytes) / std::max(1u, info.splats)});
    data.figures.push_back({size, "whole file", "bytes", double(bytes.size())});
    addWaterfall(data);
    data.evidence = avatar.evidence;
    data.limits = subject.limits;
    subject.summary = summaryOf(data, avatar.splats.count(), bytes.size());
    DPL_CHECK_OK(writeFileAtomically(context.folder / "summary.txt", subject.summary));
    return writeReport(data, context.folder);
}

}  // namespace

Status runReport(SubjectData& subject) {
    const nlohmann::json inputs = {{"pose_fit", subject.chain.keyOf("pose-fit")}, {"threads", subject.options.threadCount}};
    auto folder = subject.chain.run("report", 4, inputs, [&](StageContext& context) { return report(subject, context); });
    if (!folder) return folder.error();
    for (const char* name : {"report.html", "report.json"}) {
        DPL_TRY(auto bytes, readFile(*folder / name));
        DPL_CHECK_OK(writeFileAtomically(subject.options.out / name, bytes));
    }
    DPL_TRY(auto summary, readFile(*folder / "summary.txt"));
    subject.summary.assign(summary.begin(), summary.end());
    return {};
}

}  // namespace dpl
