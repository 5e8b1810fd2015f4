// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/reconstruct.h"

#include <functional>

#include "reconstruction/base/folder_lock.h"
#include "reconstruction/run/cameras_file.h"
#include "reconstruction/run/import_scan.h"
#include "reconstruction/run/run_scan.h"
#include "reconstruction/run/stages.h"
#include "reconstruction/run/verdict_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

std::string withoutLastBreak(const std::string& text) {
    return text.substr(0, text.find_last_not_of('\n') + 1);
}

/** Runs the stage body-map, tells what to film again, and writes OUT/verdict.json. */
Result<MappedBody> mapAndTell(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                              Pictures& pictures) {
    DPL_TRY(MappedBody mapped, runBodyMap(run, ingested, body, surface, pictures));
    run.progress.note(withoutLastBreak(mapped.advice));
    DPL_CHECK_OK(writeVerdict(run, ingested, mapped));
    return mapped;
}

/** The run up to the body fit, and then `rest`. */
template <class T>
Result<T> runFromScan(const ReconstructOptions& options, Progress& progress,
                      const std::function<Result<T>(const StageRun&, const IngestedScan&, const FittedBody&)>& rest) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    DPL_TRY([[maybe_unused]] const FolderLock lock, FolderLock::take(options.out));
    Jobs jobs(options.threadCount);
    StageChain chain(options.out, progress);
    const StageRun run{chain, jobs, progress};
    if (const std::vector<std::string> old = chain.numberedFolders(); !old.empty())
        progress.note(
            formatText("{} has {} stage folders of an earlier version ({} ...). Stages run anew; the old folders are kept, delete "
                       "them to free the space",
                       (options.out / "stages").string(), old.size(), old.front()));
    const auto scan = scanToReconstruct(options, progress);
    if (!scan) return refuse(run, {"import"}, scan.error());
    DPL_TRY(const IngestedScan ingested, runIngest(run, *scan, options.models, options.persons, options.heightM));
    progress.note(withoutLastBreak(ingested.verdict));
    progress.note(ingested.validation);
    DPL_TRY(const ChosenBody chosen, chooseBody(options.body, jobs));
    DPL_TRY(const FittedBody body, runBodyFit(run, ingested, chosen));
    return rest(run, ingested, body);
}

/** Leaves the cameras that the scan does not have beside the poses; removes those of an earlier run. */
Status writeCameras(const IngestedScan& ingested, const std::filesystem::path& path) {
    if (ingested.camerasFound) return writeFileAtomically(path, camerasToJson(camerasOf(ingested.scan)));
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return {};
}

}  // namespace

Result<ReconstructResult> reconstructFrom(const StageRun& run, const IngestedScan& ingested, const FittedBody& body,
                                          const ReconstructOptions& options) {
    RunSettings settings = settingsOf(options, ingested.scan.labels);
    const ReconstructResult paths{options.out / "avatar.glb", options.out / "poses.json", options.out / "report.html", "", {}};
    Pictures pictures(ingested.scan);
    DPL_TRY(const FittedSurface surface, runSurface(run, ingested, body, pictures));
    DPL_TRY(const MappedBody mapped, mapAndTell(run, ingested, body, surface, pictures));
    DPL_TRY(const DressedBody dressed, runGarments(run, ingested, body, surface, pictures, settings));
    DPL_TRY(const RegisteredPoses registered, runRegister(run, ingested, body, surface, pictures));
    DPL_TRY(const Training training, runCoOptimise(run, ingested, body, dressed, registered, pictures, settings));
    settings = withTrainingSteps(std::move(settings), training.steps);
    Lazy<AssembledAvatar> trained([&]() -> Result<AssembledAvatar> {
        DPL_TRY(FrameSet set, framesOf(ingested, Split::Train, body.cameras, registered.poses, pictures));
        setPrecisions(set, registered.precisions);
        return assembleAvatar(body.shaped.joints, dressed.clothed, training.result, ingested.scan, std::move(set), run.jobs);
    });
    DPL_TRY(const MeasuredParts measured, runEvidence(run, ingested, body, registered, training, trained, pictures, settings));
    DPL_TRY(const Package package, runPackage(run, ingested, training, trained, measured, dressed.decided, mapped, settings));
    DPL_CHECK_OK(writeFileAtomically(paths.avatar, package.bytes));
    DPL_TRY(const FoundPoses found, runPoseFit(run, ingested, body, registered, training, package, pictures, settings));
    DPL_TRY(const auto posesBytes, readFile(found.file));
    DPL_CHECK_OK(writeFileAtomically(paths.poses, posesBytes));
    DPL_CHECK_OK(writeCameras(ingested, camerasBeside(paths.poses)));
    DPL_TRY(const StageOutput report, runReport(run, ingested, body, training, package, found, mapped, pictures, settings));
    for (const char* name : {"report.html", "report.json"}) {
        DPL_TRY(const auto bytes, readFile(report.folder / name));
        DPL_CHECK_OK(writeFileAtomically(options.out / name, bytes));
    }
    DPL_TRY(const auto summary, readFile(report.folder / "summary.txt"));
    ReconstructResult result = paths;
    result.summary.assign(summary.begin(), summary.end());
    result.stages = run.chain.records();
    return result;
}

Result<ReconstructResult> reconstruct(const ReconstructOptions& options, Progress& progress) {
    auto result =
        runFromScan<ReconstructResult>(options, progress, [&](const StageRun& run, const IngestedScan& ingested, const FittedBody& body) {
            return reconstructFrom(run, ingested, body, options);
        });
    if (!result && result.error().code == Code::Cancelled)
        return fail(Code::Cancelled, "{}. Nothing that was finished is lost: run the same command again to go on", result.error().message);
    return result;
}

Result<std::string> checkFilm(const ReconstructOptions& options, Progress& progress) {
    return runFromScan<std::string>(options, progress,
                                    [&](const StageRun& run, const IngestedScan& ingested, const FittedBody& body) -> Result<std::string> {
                                        Pictures pictures(ingested.scan);
                                        DPL_TRY(const FittedSurface surface, runSurface(run, ingested, body, pictures));
                                        DPL_TRY(const MappedBody mapped, runBodyMap(run, ingested, body, surface, pictures));
                                        DPL_CHECK_OK(writeVerdict(run, ingested, mapped));
                                        return mapped.advice;
                                    });
}

}  // namespace dpl
