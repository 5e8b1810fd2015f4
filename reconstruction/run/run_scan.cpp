// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/run_scan.h"

#include <algorithm>

#include "reconstruction/run/cameras_file.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/subject/body/fit_body.h"

namespace dpl {
namespace {

Result<Scan> withTheRunsCameras(const std::filesystem::path& folder, const std::filesystem::path& camerasPath) {
    std::error_code missing;
    if (!std::filesystem::exists(camerasPath, missing)) return readScan(folder);
    DPL_TRY(Scan scan, readScan(folder, ScanCameras::MayLack));
    DPL_TRY(const FoundCameras found, readCamerasFile(camerasPath));
    return withCameras(std::move(scan), found);
}

}  // namespace

std::filesystem::path camerasBeside(const std::filesystem::path& posesPath) {
    return posesPath.parent_path() / "cameras.json";
}

Result<RunScan> readRunScan(const std::filesystem::path& folder, const std::filesystem::path& posesPath) {
    std::error_code error;
    if (!std::filesystem::exists(posesPath, error))
        return fail(Code::NotFound, "{}: no such file; name the poses.json of the reconstruction with --poses", posesPath.string());
    RunScan run;
    DPL_TRY(run.scan, withTheRunsCameras(folder, camerasBeside(posesPath)));
    DPL_TRY(PosesFile all, readPosesFile(posesPath));
    if (!run.scan.metricWorld && all.metresPerUnit == 0)
        return fail(Code::Unsupported, "{} does not say how long a unit of the scan's cameras is; run doppel reconstruct again",
                    posesPath.string());
    if (!all.scanHash.empty()) {
        DPL_TRY(const Scan given, readScan(folder, ScanCameras::MayLack));
        if (hashOfScan(given, hashFrames(given)) != all.scanHash)
            return fail(Code::InvalidArgument,
                        "{} is not the scan that {} was made of: its pictures are others; name that scan, or reconstruct this one",
                        folder.string(), posesPath.string());
    }
    run.poses.scanHash = std::move(all.scanHash), run.poses.avatarHash = std::move(all.avatarHash);
    run.poses.jointNames = std::move(all.jointNames), run.poses.metresPerUnit = all.metresPerUnit;
    run.poses.restPositions = std::move(all.restPositions);
    for (ScanFrame& frame : run.scan.frames) {
        const auto found = std::find_if(all.frames.begin(), all.frames.end(), [&](const FramePose& p) { return p.name == frame.name; });
        if (found == all.frames.end())
            return fail(Code::NotFound, "{} has no pose for frame {}; name the poses.json of this scan with --poses", posesPath.string(),
                        frame.name);
        if (found->split == Split::Validation && frame.split == Split::Train) frame.split = Split::Validation;
        run.cameras.push_back(metricCamera(frame.camera, run.scan.metricWorld ? 1 : all.metresPerUnit));
        run.poses.frames.push_back(*found);
    }
    return run;
}

}  // namespace dpl
