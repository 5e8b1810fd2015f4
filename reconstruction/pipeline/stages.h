// SPDX-License-Identifier: Apache-2.0
// The stages of a reconstruction. Each takes values and returns a value; none changes what another has made. What a stage returns is read
// back from its folder, so a finished stage and one that has just run give the same.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "reconstruction/body/fit_body.h"
#include "reconstruction/capture/scan.h"
#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/assemble_avatar.h"
#include "reconstruction/pipeline/evidence_file.h"
#include "reconstruction/pipeline/lazy.h"
#include "reconstruction/pipeline/preset.h"
#include "reconstruction/pipeline/stage.h"
#include "reconstruction/pipeline/train_frames.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** What stages run with. No result depends on it. */
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
    BodyModel body, shaped;  // as chosen, and at the fitted shape
    BodyFit fit;
    std::vector<Camerad> cameras;  // of Scan::frames, in metres
    std::string key;
};

struct FittedSurface {
    std::vector<Vec3f> restOffsets;  // V, rest pose, metres: from the shaped body to the clothed surface
    std::vector<Pose> poses;         // of Scan::frames: the body fit's, and what silhouettes show of the sway of still frames
    std::string key;
};

struct Training {
    CoOptimiseResult result;
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
    std::filesystem::path file;  // poses.json of the stage
    PosesFile poses;
    std::string key;
};

/** Reads and checks the scan. With `models` (a folder of networks; may be empty) what the scan lacks is observed first. */
Result<IngestedScan> runIngest(const StageRun& run, const std::filesystem::path& scan, const std::filesystem::path& models);
/** The body of a file; empty: the built-in one. */
Result<ChosenBody> chooseBody(const std::filesystem::path& file, Jobs& jobs);
Result<FittedBody> runBodyFit(const StageRun& run, const IngestedScan& ingested, ChosenBody chosen);
/** What a body-fit stage left in its folder. */
Result<FittedBody> readFittedBody(const StageOutput& stage, const IngestedScan& ingested, BodyModel body);
Result<FittedSurface> runSurface(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, Pictures& pictures);
/** Decides which parts are modelled as layers of their own: in this version none. */
Result<std::vector<EvidenceData>> runGarments(const StageRun& run);
Result<Training> runCoOptimise(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                               Pictures& pictures, const RunSettings& settings);
/** Measures on training frames what each optional part of the trained avatar is worth. */
Result<MeasuredParts> runEvidence(const StageRun& run, const IngestedScan& ingested, const Training& training,
                                  Lazy<AssembledAvatar>& trained);
/** Leaves out the parts that did not pay, polishes on the decoded bytes and encodes. `decided`: rows of parts that were never trained. */
Result<Package> runPackage(const StageRun& run, const IngestedScan& ingested, const Training& training, Lazy<AssembledAvatar>& trained,
                           const MeasuredParts& measured, const std::vector<EvidenceData>& decided, const RunSettings& settings);
/** Poses of all frames; those of held-out frames are fitted to the finished avatar. */
Result<FoundPoses> runPoseFit(const StageRun& run, const IngestedScan& ingested, const FittedBody& body, const FittedSurface& surface,
                              const Training& training, const Package& package, Pictures& pictures, const RunSettings& settings);
/** Writes report.html, report.json and summary.txt into the returned folder. */
Result<StageOutput> runReport(const StageRun& run, const IngestedScan& ingested, const FittedBody& body,
                              const std::vector<EvidenceData>& decided, const Training& training, const Package& package,
                              const FoundPoses& found, Pictures& pictures, const RunSettings& settings);

/** Every stage after the body fit; writes avatar.glb, poses.json and the report into options.out. */
Result<ReconstructResult> reconstructFrom(const StageRun& run, const IngestedScan& ingested, const FittedBody& body,
                                          const ReconstructOptions& options);

}  // namespace dpl
