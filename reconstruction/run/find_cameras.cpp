// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/find_cameras.h"

#include "reconstruction/base/folder_lock.h"
#include "reconstruction/run/camera_errors.h"
#include "reconstruction/run/stages.h"

namespace dpl {

Result<std::string> findCameras(const FindCamerasOptions& options, Progress& progress) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    DPL_TRY([[maybe_unused]] const FolderLock lock, FolderLock::take(options.out));
    DPL_TRY(Scan scan, readScan(options.scan, ScanCameras::MayLack));
    Jobs jobs;
    StageChain chain(options.out, progress);
    const StageRun run{chain, jobs, progress};
    if (scan.camerasKnown) {
        DPL_TRY(std::optional<Scan> repaired, runCameraRepair(run, scan));
        if (repaired) scan = std::move(*repaired);
    } else {
        if (options.heightM > 0) scan.subjectHeightM = options.heightM;
        DPL_TRY(scan, runCameras(run, scan));
    }
    std::string summary = chain.records().empty()
                              ? std::string("the scan has cameras, and its keypoints agree with them\n")
                              : formatText("wrote {}\n", (options.out / "stages" / "cameras" / "cameras.json").string());
    if (options.truth.empty()) return summary;
    DPL_TRY(const Scan truth, readScan(options.truth));
    DPL_TRY(const CameraErrors errors, compareCameras(scan, truth));
    return summary + describeCameraErrors(errors);
}

}  // namespace dpl
