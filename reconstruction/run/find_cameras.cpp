// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/find_cameras.h"

#include "reconstruction/base/folder_lock.h"
#include "reconstruction/run/camera_errors.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_cameras.h"
#include "reconstruction/run/stage_observe.h"

namespace dpl {

Result<std::string> findCameras(const FindCamerasOptions& options, Progress& progress) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    DPL_TRY([[maybe_unused]] const FolderLock lock, FolderLock::take(options.out));
    DPL_TRY(Scan given, readScan(options.scan, ScanCameras::MayLack));
    if (!given.camerasKnown && options.heightM > 0) given.subjectHeightM = options.heightM;
    Jobs jobs;
    StageChain chain(options.out, progress);
    Run run(chain, jobs, progress);
    std::vector<FrameHashes> hashes = hashFrames(given);
    run.put(SeenScan{std::move(given), std::move(hashes), {}}, "scan");  // as it is: no networks look at it
    DPL_TRY(const PlacedScan* placed, run.get<PlacedScan>());
    const Scan& scan = placed->scan;
    std::string summary = chain.records().empty()
                              ? std::string("the scan has cameras, and its keypoints agree with them\n")
                              : formatText("wrote {}\n", (options.out / "stages" / "cameras" / "cameras.json").string());
    if (options.truth.empty()) return summary;
    DPL_TRY(const Scan truth, readScan(options.truth));
    DPL_TRY(const CameraErrors errors, compareCameras(scan, truth));
    return summary + describeCameraErrors(errors);
}

}  // namespace dpl
