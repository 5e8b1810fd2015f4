// SPDX-License-Identifier: Apache-2.0
// The stages of a reconstruction. Each takes values and returns a value, and none changes another's files. A stage reads its return value
// back from its folder, so the value is the same whether the stage has just run or was finished before.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/judging/evidence/evidence_file.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/assemble_avatar.h"
#include "reconstruction/run/lazy.h"
#include "reconstruction/run/preset.h"
#include "reconstruction/run/stage.h"
#include "reconstruction/run/train_frames.h"
#include "reconstruction/subject/body/fit_body.h"
#include "reconstruction/subject/garments/clothed_mesh.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** The services that stages use. No result depends on them. */
struct StageRun {
    StageChain& chain;
    Jobs& jobs;
    Progress& progress;
};

/** A body before any fit, with the hash of its file bytes. */
struct ChosenBody {
    BodyModel body;
    std::string hash;
};

struct FittedBody {
    BodyModel shaped;              // the chosen body at the fitted shape, with its shoulders at rest as in the still pose
    BodyFit fit;                   // poses: of `shaped`
    std::vector<Camerad> cameras;  // of Scan::frames, in metres
    std::string key;
};

struct FittedSurface {
    std::vector<Vec3f> restOffsets;  // V, rest pose, metres: from the shaped body to the clothed surface
    std::vector<Pose> poses;         // of Scan::frames; the body fit's, still frames corrected for sway by silhouettes
    std::string key;
};

/** How the still training pictures show the fitted surface (reconstruction/judging/coach). */
struct MappedBody {
    std::string advice;                          // what to film again, lines of text
    nlohmann::ordered_json figures;              // {film_again: [{shot, sentence, gain}], places: [...]}
    std::vector<std::vector<uint8_t>> pictures;  // PNG: size of a pixel, number of pictures, blur
    CaptureMapData capture;                      // for the avatar's file
    std::string key;
};

/** The clothed subject as layers. */
struct DressedBody {
    ClothedMesh clothed;
    std::vector<EvidenceData> decided;  // which labels became layers, and why
    std::string key;
};

struct RegisteredPoses {
    std::vector<Pose> poses;                                       // of Scan::frames; those of held-out frames from their keypoints alone
    std::vector<std::shared_ptr<const PosePrecision>> precisions;  // of `poses`
    std::string key;
};

struct Training {
    CoOptimiseResult result;
    uint32_t steps = 0;  // that it took; a time budget decides them
    std::string key;
};

struct MeasuredParts {
    std::vector<PartEvidence> parts;
    std::string key;
};

struct Package {
    std::vector<uint8_t> bytes;  // of avatar.glb
    std::string key;
};

struct FoundPoses {
    std::filesystem::path file;  // poses.json in the stage's folder
    PosesFile poses;
    std::string key;
};

/** Finds the cameras of a scan that has none. Frames that get no camera are dropped. The verdict goes to run.progress; when it refuses, it
 *  is the error. */
Result<Scan> runCameras(const StageRun& run, const Scan& scan);
/** Checks the cameras that a scan brings, where its keypoints raise doubt, and repairs them where the pictures agree on others.
 *  Nothing: the scan keeps its cameras. */
Result<std::optional<Scan>> runCameraRepair(const StageRun& run, const Scan& scan);
/** Checks the masks of close-ups that lie in the folder `found`. Wrong ones are replaced by the hull of the full-body masks, or emptied. */
Result<Scan> runCloseups(const StageRun& run, Scan scan, const std::filesystem::path& found);
/** Reads and checks the scan. `models` is a folder of networks; if empty, installedModels() is taken where the scan lacks something.
 * `persons`: ReconstructOptions::persons. The networks first add keypoints, labels and masks that the scan lacks; then
 *  runCameras() finds its cameras, if it has none. heightM: of the subject, in place of the scan's; 0: the scan's. */
Result<IngestedScan> runIngest(const StageRun& run, const std::filesystem::path& scan, const std::filesystem::path& models,
                               const std::vector<std::string>& persons = {}, double heightM = 0);
/** Reads the body from `file`, or takes the built-in one if `file` is empty. */
Result<ChosenBody> chooseBody(const std::filesystem::path& file, Jobs& jobs);
Result<FittedBody> runBodyFit(const StageRun& run, const IngestedScan& ingested, const ChosenBody& chosen);
/** Reads the result of a finished body-fit stage. */
Result<FittedBody> readFittedBody(const StageOutput& stage, const IngestedScan& ingested, const BodyModel& body);
Result<FittedSurface> runSurface(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, Pictures& pictures);
/** Maps the surface and finds what to film again. Reads no picture of a held-out frame. */
Result<MappedBody> runBodyMap(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                              Pictures& pictures);
/** Makes body, garments, shoes and hair as layers of their own. Without labels, or without settings.layers, the result is one layer. */
Result<DressedBody> runGarments(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                                Pictures& pictures, const RunSettings& settings);
/** Registers training frames to their pictures. Reads no picture of a held-out frame. */
Result<RegisteredPoses> runRegister(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                                    Pictures& pictures);
Result<Training> runCoOptimise(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const DressedBody& dressed,
                               const RegisteredPoses& registered, Pictures& pictures, const RunSettings& settings);
/** Measures on validation frames how much each optional part improves the trained avatar; on training frames where the scan has no
 *  validation split. */
Result<MeasuredParts> runEvidence(const StageRun& run, const IngestedScan& ingested, const FittedBody& body,
                                  const RegisteredPoses& registered, const Training& training, Lazy<AssembledAvatar>& trained,
                                  Pictures& pictures, const RunSettings& settings);
/** Removes the parts that the evidence rejects, polishes the decoded avatar and encodes it, with the capture map. `decided`: evidence rows
 * of parts that were not trained. */
Result<Package> runPackage(const StageRun& run, const IngestedScan& ingested, const Training& training, Lazy<AssembledAvatar>& trained,
                           const MeasuredParts& measured, const std::vector<EvidenceData>& decided, const MappedBody& mapped,
                           const RunSettings& settings);
/** Poses of all frames. Those of validation and held-out frames are fitted to the finished avatar. */
Result<FoundPoses> runPoseFit(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const RegisteredPoses& registered,
                              const Training& training, const Package& package, Pictures& pictures, const RunSettings& settings);
/** Writes report.html, report.json and summary.txt into the returned folder. */
Result<StageOutput> runReport(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const Training& training,
                              const Package& package, const FoundPoses& found, const MappedBody& mapped, Pictures& pictures,
                              const RunSettings& settings);

/** Runs every stage after the body fit. Writes avatar.glb, poses.json and the report into options.out. */
Result<ReconstructResult> reconstructFrom(const StageRun& run, const IngestedScan& ingested, const FittedBody& body,
                                          const ReconstructOptions& options);

}  // namespace dpl
