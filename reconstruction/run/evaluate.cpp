// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/evaluate.h"

#include <cstdio>

#include "reconstruction/judging/ladder/ladder.h"
#include "reconstruction/judging/report/error_map.h"
#include "reconstruction/judging/report/plain_words.h"
#include "reconstruction/judging/report/published_score.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/frame_scores.h"
#include "reconstruction/run/live_person.h"
#include "reconstruction/run/portrait.h"
#include "reconstruction/run/run_scan.h"

namespace dpl {
namespace {

/** The scores of the held-out frames by the protocol that the scan states, as a line. Poses are those fitted to the frames. */
Result<std::string> publishedLine(const Scan& scan, const FrameSet& heldOut, AvatarView& view, const PosesFile& poses, const Lpips* lpips) {
    std::vector<PublishedScore> scores;
    for (size_t i = 0; i < heldOut.frames.size(); ++i) {
        const TrainFrame& frame = heldOut.frames[i];
        DPL_RETURN_IF_ERROR(taskAt(double(i) / double(heldOut.frames.size()), frame.name + ", published protocol"));
        const FramePose& found = poses.frames[heldOut.rows[i]];
        DPL_TRY(const auto rgba, view.draw(found.bestPose(), frame.camera));
        DPL_TRY(const auto picture, frame.picture.get());
        auto score = scoreAsPublished(rgba, picture->image, picture->mask, lpips);
        if (!score) return fail(score.error().code, "frame '{}': {}", frame.name, score.error().message);
        scores.push_back(*score);
    }
    const auto mean = meanOf(scores);
    if (!mean) return std::string();
    char line[200];
    std::snprintf(line, sizeof line, "\nprotocol %s, %zu held-out frames: PSNR %.2f dB, SSIM %.4f, LPIPS ", scan.protocol.c_str(),
                  scores.size(), mean->psnrDb, mean->ssim);
    std::string text = line;
    if (!mean->lpips) return text + "needs weights (--lpips)";
    std::snprintf(line, sizeof line, "%.4f", *mean->lpips);
    return text + line;
}

}  // namespace

Result<std::string> evaluateAvatar(const EvaluateOptions& options, Progress& progress) {
    const std::filesystem::path posesPath = options.poses.empty() ? options.avatar.parent_path() / "poses.json" : options.poses;
    DPL_TRY(const auto bytes, readAvatarBytes(options.avatar));
    DPL_TRY(const AvatarData avatar, avatarOf(options.avatar, bytes, "poses"));
    FrameTable table;
    DPL_TRY(RunScan shown, readRunScan(options.scan, posesPath));
    table.scan = std::move(shown.scan);
    PosesFile& poses = shown.poses;
    rememberPoses(table.scan, avatar.correctives.motion, poses);
    const std::vector<Camerad>& cameras = shown.cameras;
    if (!options.lpips.empty() && table.scan.protocol.empty())
        return fail(Code::InvalidArgument, "{} states no published protocol, so LPIPS has no use; leave --lpips out",
                    options.scan.string());
    std::optional<Lpips> lpips;
    if (!options.lpips.empty()) {
        DPL_TRY(lpips, Lpips::load(options.lpips));
    }
    table.usable.assign(table.scan.frames.size(), true);
    DPL_RETURN_IF_ERROR(checkSkeleton(poses, posesPath, avatar.joints, options.avatar));
    if (!options.out.empty()) {
        std::error_code error;
        std::filesystem::create_directories(options.out, error);
        if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    }
    const std::vector<Pose> found = poses.poses();
    Jobs jobs(options.threadCount);
    ShownTask task(progress);
    const TaskScope scope(&task);
    ReportData data;
    data.title = "Doppel: " + table.scan.name;
    data.facts = {{"scan", table.scan.root.filename().string() + ", " + poses.scanHash}, {"avatar", options.avatar.string()}};
    progress.beginStage("evaluate");
    DPL_TRY(auto view, AvatarView::open(bytes, options.threadCount));
    DPL_TRY(const LabelColours labelColours, gatherLabelColours(table));
    for (const auto& [split, frames] : {std::pair{Split::Test, &data.frames}, {Split::Validation, &data.validation}}) {
        const FrameSet set = table.frames(split, cameras, found);
        DPL_TRY(*frames, scoreFrames(labelColours, set, avatar, view, poses, split == Split::Test, jobs));
    }
    if (data.frames.empty() && data.validation.empty())
        return fail(Code::NotFound, "{} has no mask of a held-out or validation frame, and scores are taken inside masks; add their masks",
                    options.scan.string());
    std::string summary = scoreLines(data.frames, "held-out") + scoreLines(data.validation, "validation");
    if (!table.scan.protocol.empty()) {
        const FrameSet heldOut = table.frames(Split::Test, cameras, found);
        DPL_TRY(const std::string line, publishedLine(table.scan, heldOut, view, poses, lpips ? &*lpips : nullptr));
        summary += line;
    }
    if (!summary.empty()) summary.erase(0, 1);
    if (options.ladder) {
        DPL_TRY(data.ladder, measureLadder({table.scan, cameras, avatar, poses}, jobs));
        if (!data.ladder)
            return fail(Code::NotFound, "{} has no truth (truth.json, geometry/), which the ladder needs; leave --ladder out",
                        options.scan.string());
        summary += "\n" + ladderText(*data.ladder);
    }
    summary += "\n\n" + verdictSentence(data);
    progress.endStage(formatText("{} held-out frames", data.frames.size()));
    if (options.out.empty()) return summary;
    data.evidence = avatar.evidence;
    DPL_TRY(data.portrait, drawPortrait(table.scan, cameras, poses, avatar, view, jobs));
    DPL_TRY(data.errorMap, drawErrorMap(avatar.mesh, data.frames));
    DPL_RETURN_IF_ERROR(bringToLife(options.web, bytes, avatar, data));
    DPL_RETURN_IF_ERROR(writeReport(data, options.out));
    return summary + formatText("\nOpen {} to see the avatar beside these pictures.", (options.out / "report.html").string());
}

}  // namespace dpl
