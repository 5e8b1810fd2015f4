// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/evaluate.h"

#include <algorithm>
#include <cstdio>

#include "reconstruction/body/fit_body.h"
#include "reconstruction/ladder/ladder.h"
#include "reconstruction/package/avatar_bytes.h"
#include "reconstruction/pipeline/frame_scores.h"
#include "reconstruction/report/published_score.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

/** The poses in the order of the scan's frames. Also sets the frames' splits to those of the reconstruction. */
Result<PosesFile> posesOf(Scan& scan, const AvatarData& avatar, const std::filesystem::path& path) {
    DPL_TRY(const PosesFile all, readPosesFile(path));
    if (all.jointNames.size() != avatar.joints.size())
        return fail(Code::InvalidArgument, "{} poses {} joints, the avatar has {}; name the poses.json of its reconstruction with --poses",
                    path.string(), all.jointNames.size(), avatar.joints.size());
    if (!scan.metricWorld && all.metresPerUnit == 0)
        return fail(Code::Unsupported, "{} does not say how long a unit of the scan's cameras is; run doppel reconstruct again",
                    path.string());
    PosesFile poses{all.jointNames, all.metresPerUnit, {}};
    for (ScanFrame& frame : scan.frames) {
        const auto found = std::find_if(all.frames.begin(), all.frames.end(), [&](const FramePose& p) { return p.name == frame.name; });
        if (found == all.frames.end())
            return fail(Code::NotFound, "{} has no pose for frame {}; name the poses.json of this scan with --poses", path.string(),
                        frame.name);
        if (found->split == "validation" && frame.split == Split::Train) frame.split = Split::Validation;
        poses.frames.push_back(*found);
    }
    return poses;
}

/** The scores of the held-out frames by the protocol that the scan states, as a line. Poses are those fitted to the frames. */
Result<std::string> publishedLine(const Scan& scan, const FrameSet& heldOut, AvatarView& view, const PosesFile& poses, const Lpips* lpips,
                                  const std::function<bool(double, const std::string&)>& tell) {
    std::vector<PublishedScore> scores;
    for (size_t i = 0; i < heldOut.frames.size(); ++i) {
        const TrainFrame& frame = heldOut.frames[i];
        if (!tell(double(i) / double(heldOut.frames.size()), frame.name + ", published protocol")) return fail(Code::Cancelled, "stopped");
        const FramePose& found = poses.frames[heldOut.indices[i]];
        DPL_TRY(const auto rgba, view.draw(found.fittedPose ? *found.fittedPose : found.pose, frame.camera));
        auto score = scoreAsPublished(rgba, frame.picture->image, frame.picture->mask, lpips);
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
    IngestedScan ingested;
    DPL_TRY(ingested.scan, readScan(options.scan));
    if (!options.lpips.empty() && ingested.scan.protocol.empty())
        return fail(Code::InvalidArgument, "{} states no published protocol, so LPIPS has no use; leave --lpips out",
                    options.scan.string());
    std::optional<Lpips> lpips;
    if (!options.lpips.empty()) {
        DPL_TRY(lpips, Lpips::load(options.lpips));
    }
    ingested.usable.assign(ingested.scan.frames.size(), true);
    DPL_TRY(const auto bytes, readAvatarBytes(options.avatar));
    DPL_TRY(const AvatarData avatar, readAvatar(bytes));
    DPL_TRY(const PosesFile poses,
            posesOf(ingested.scan, avatar, options.poses.empty() ? options.avatar.parent_path() / "poses.json" : options.poses));
    std::vector<Camerad> cameras;
    std::vector<Pose> registered;
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f)
        cameras.push_back(metricCamera(ingested.scan.frames[f].camera, ingested.scan.metricWorld ? 1 : poses.metresPerUnit)),
            registered.push_back(poses.frames[f].pose);
    Jobs jobs(options.threadCount);
    Pictures pictures(ingested.scan);
    const auto tell = [&](double share, const std::string& what) {
        progress.update(share, what);
        return !progress.cancelled();
    };
    ReportData data;
    data.title = "Doppel: " + ingested.scan.name;
    data.facts = {{"scan", ingested.scan.root.filename().string()}, {"avatar", options.avatar.string()}};
    progress.beginStage("evaluate");
    DPL_TRY(auto view, AvatarView::open(bytes, options.threadCount));
    DPL_TRY(const LabelColours labelColours, gatherLabelColours(ingested, pictures));
    for (const auto& [split, frames] : {std::pair{Split::Test, &data.frames}, {Split::Validation, &data.validation}}) {
        DPL_TRY(const FrameSet set, framesOf(ingested, split, cameras, registered, pictures));
        DPL_TRY(*frames, scoreFrames(labelColours, set, avatar, view, poses, split == Split::Test, jobs, tell));
    }
    std::string summary = scoreLines(data.frames, "held-out") + scoreLines(data.validation, "validation");
    if (!ingested.scan.protocol.empty()) {
        DPL_TRY(const FrameSet heldOut, framesOf(ingested, Split::Test, cameras, registered, pictures));
        DPL_TRY(const std::string line, publishedLine(ingested.scan, heldOut, view, poses, lpips ? &*lpips : nullptr, tell));
        summary += line;
    }
    if (!summary.empty()) summary.erase(0, 1);
    if (options.ladder) {
        DPL_TRY(data.ladder, measureLadder({ingested.scan, cameras, avatar, poses, tell}, jobs));
        if (!data.ladder)
            return fail(Code::NotFound, "{} has no truth (truth.json, geometry/), which the ladder needs; leave --ladder out",
                        options.scan.string());
        summary += "\n" + ladderText(*data.ladder);
    }
    progress.endStage(formatText("{} held-out frames", data.frames.size()));
    if (options.out.empty()) return summary;
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    DPL_CHECK_OK(writeReport(data, options.out));
    return summary + "\nopen " + (options.out / "report.html").string();
}

}  // namespace dpl
