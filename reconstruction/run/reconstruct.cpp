// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/reconstruct.h"

#include "reconstruction/base/folder_lock.h"
#include "reconstruction/judging/ladder/true_mesh.h"
#include "reconstruction/judging/report/bar_contrast.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/run/cameras_file.h"
#include "reconstruction/run/frames_file.h"
#include "reconstruction/run/import_scan.h"
#include "reconstruction/run/output_claim.h"
#include "reconstruction/run/preset.h"
#include "reconstruction/run/run_news.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/run_scan.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_body_map.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_garments.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_observe.h"
#include "reconstruction/run/stage_package.h"
#include "reconstruction/run/stage_pose_fit.h"
#include "reconstruction/run/stage_report.h"
#include "reconstruction/run/verdict_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

std::string withoutLastBreak(const std::string& text) {
    return text.substr(0, text.find_last_not_of('\n') + 1);
}

/** Writes OUT/verdict.json. avatarHash: empty before there is an avatar. */
Status tellVerdict(Run& run, const std::string& avatarHash = {}) {
    DPL_TRY(const FrameTable* table, run.get<FrameTable>());
    DPL_TRY(const MappedBody* mapped, run.get<MappedBody>());
    return writeVerdict(run.chain().outFolder(), {table->scanHash, avatarHash, mapped->figures, table->check});
}

/** Checks the film: scan, body and surface, and what to film again. */
Result<const MappedBody*> mapAndTell(Run& run) {
    DPL_TRY(const FrameTable* table, run.get<FrameTable>());
    run.progress().note(withoutLastBreak(table->verdict));
    run.progress().note(table->validation);
    DPL_TRY(const MappedBody* mapped, run.get<MappedBody>());
    DPL_RETURN_IF_ERROR(tellVerdict(run));
    return mapped;
}

/** Leaves a page that says how to go on, for who looks before the run ends or after it was stopped. A page that is there stays. */
Status tellUnfinished(Run& run, const MappedBody& mapped) {
    const std::filesystem::path page = run.chain().outFolder() / "report.html";
    std::error_code error;
    if (std::filesystem::exists(page, error)) return {};
    DPL_TRY(const FrameTable* table, run.get<FrameTable>());
    FilmAgainSection filmAgain{mapped.advice, {}, {}, {}, {}};
    for (const auto& [key, sentence] : shotsOf(mapped)) filmAgain.cards.push_back({sentence, {}});
    return writeFileAtomically(page, unfinishedHtml("Doppel: " + table->scan.name, filmAgain));
}

/** Leaves the cameras that the scan does not have beside the poses; removes those of an earlier run. */
Status writeCameras(const FrameTable& table, const std::filesystem::path& path) {
    if (table.camerasFound) return writeFileAtomically(path, camerasToJson(camerasOf(table.scan)));
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return {};
}

/** A checkpoint in the output folder would be removed before it is read. */
Status checkFrom(const ReconstructOptions& options) {
    if (options.from.empty()) return {};
    std::error_code error;
    const auto file = std::filesystem::weakly_canonical(options.from, error), out = std::filesystem::weakly_canonical(options.out, error);
    const auto inside = file.lexically_relative(out);
    if (inside.empty() || *inside.begin() == "..") return {};
    return fail(Code::InvalidArgument, "{} lies in the output folder, which this run changes; choose another output with -o",
                options.from.string());
}

/** Gives `work` a run with the request, and returns what it returns. */
template <class T>
Result<T> withRequest(const ReconstructOptions& options, Progress& progress, const std::function<Result<T>(Run&)>& work) {
    Jobs jobs(options.threadCount);
    StageChain chain(options.out, progress);
    Run run(chain, jobs, progress);
    const auto scan = scanToReconstruct(options, progress);
    if (!scan) return refuse(options.out, {"import"}, scan.error());
    run.put(RunRequest{*scan, options}, "request");
    DPL_TRY(const ReadScan* read, run.get<ReadScan>());
    DPL_RETURN_IF_ERROR(claimOutput(options, read->scan, read->hashes));
    DPL_RETURN_IF_ERROR(checkTruth(read->scan));
    if (const auto bars = readPrintedBars(read->scan.root); !bars) return bars.error();
    return work(run);
}

/** Locks the output folder, tells who watches it, and returns what `work` returns. lastStage: to which `work` comes, for the time left;
 *  empty: nothing is told of it. */
template <class T>
Result<T> withRun(const ReconstructOptions& options, Progress& progress, std::string_view lastStage,
                  const std::function<Result<T>(Run&)>& work) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    DPL_TRY([[maybe_unused]] const FolderLock lock, FolderLock::take(options.out));
    DPL_RETURN_IF_ERROR(checkOutputIsFree(options));
    RunNews news(options.out);
    const RunSettings settings = settingsOf(options);
    news.plan({settings.training.steps, settings.polishSteps, settings.poseFit.iterations, lastStage});
    auto result = [&] {
        const ToldNews told(progress, news);
        return withRequest<T>(options, progress, work);
    }();
    news.ended(result ? Status() : Status(result.error()));
    return result;
}

}  // namespace

Result<ReconstructResult> completeRun(Run& run) {
    const std::filesystem::path out = run.chain().outFolder();
    ReconstructResult result{out / "avatar.glb", out / "poses.json", out / "report.html", "", "", "", {}};
    DPL_TRY(const MappedBody* mapped, mapAndTell(run));
    run.progress().note(withoutLastBreak(mapped->advice));
    DPL_RETURN_IF_ERROR(tellUnfinished(run, *mapped));
    DPL_RETURN_IF_ERROR(run.get<GarmentLayers>());
    DPL_TRY(const Package* package, run.get<Package>());
    DPL_RETURN_IF_ERROR(writeFileAtomically(result.avatar, package->bytes));
    DPL_TRY(const FoundPoses* found, run.get<FoundPoses>());
    DPL_TRY(const auto posesBytes, readFile(found->file));
    DPL_RETURN_IF_ERROR(writeFileAtomically(result.poses, posesBytes));
    DPL_RETURN_IF_ERROR(tellVerdict(run, found->poses.avatarHash));
    DPL_TRY(const FrameTable* table, run.get<FrameTable>());
    DPL_RETURN_IF_ERROR(writeCameras(*table, camerasBeside(result.poses)));
    DPL_TRY(const MetricCameras* metric, run.get<MetricCameras>());
    DPL_RETURN_IF_ERROR(writeFileAtomically(out / "frames.json", framesToJson(table->scan, metric->cameras, out)));
    DPL_TRY(const ReportFiles* report, run.get<ReportFiles>());
    for (const char* name : {"report.html", "report.json", "portrait.jpg"}) {
        DPL_TRY(const auto bytes, readFile(report->folder / name));
        std::error_code ignored;
        if (bytes.empty())
            std::filesystem::remove(out / name, ignored);  // of an earlier run
        else
            DPL_RETURN_IF_ERROR(writeFileAtomically(out / name, bytes));
    }
    result.word = report->word, result.words = report->words, result.summary = report->summary;
    result.stages = run.chain().records();
    return result;
}

Result<ReconstructResult> reconstruct(const ReconstructOptions& options, Progress& progress) {
    DPL_RETURN_IF_ERROR(checkFrom(options));
    auto result = withRun<ReconstructResult>(options, progress, "report", completeRun);
    if (!result && result.error().code == Code::Cancelled)
        return fail(Code::Cancelled, "{}. Nothing that was finished is lost: run the same command again to go on", result.error().message);
    return result;
}

Result<std::string> checkFilm(const ReconstructOptions& options, Progress& progress) {
    return withRun<std::string>(options, progress, "body-map", [](Run& run) -> Result<std::string> {
        DPL_TRY(const MappedBody* mapped, mapAndTell(run));
        return mapped->advice;
    });
}

Result<ProfiledTraining> profileTraining(const ReconstructOptions& options, const ProfiledSteps& steps, Progress& progress) {
    return withRun<ProfiledTraining>(options, progress, "", [&](Run& run) -> Result<ProfiledTraining> {
        run.put(steps, "profiled steps");
        DPL_TRY(const ProfiledTraining* profiled, run.get<ProfiledTraining>());
        return *profiled;
    });
}

}  // namespace dpl
