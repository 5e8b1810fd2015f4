// SPDX-License-Identifier: Apache-2.0
// What the stages hand on in memory. Everything here can be rebuilt from the scan and the finished stage folders.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "reconstruction/body/fit_body.h"
#include "reconstruction/capture/scan.h"
#include "reconstruction/pipeline/reconstruct.h"
#include "reconstruction/pipeline/stage.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct SubjectData {
    const ReconstructOptions& options;
    Jobs& jobs;
    StageChain& chain;

    Scan scan;                 // cameras are metric after the body fit
    std::vector<bool> usable;  // per frame: false where ingest refused the frame
    std::string verdict;       // of the scan check
    std::string bodyHash;
    BodyModel body, shaped;  // as chosen, and at the fitted shape
    BodyFit fit;
    std::vector<Vec3f> surfaceOffsets;  // V, rest pose, metres: the clothed surface
    std::vector<EvidenceData> evidence;
    std::vector<std::string> limits;
    std::string summary;                                                                // for the terminal
    std::filesystem::path trainedFolder, evidenceFolder, packageFolder, poseFitFolder;  // finished stages
};

/** Hash of what may be learned from: images, masks, labels, keypoints and cameras of usable training frames, and nothing of held-out ones.
 */
Result<std::string> trainingDataHash(const SubjectData& subject);

Status runIngest(SubjectData& subject);
Status runBodyFit(SubjectData& subject);
Status runSurface(SubjectData& subject);
/** In this version: decides that garments are not modelled as layers, and says so. */
Status runGarments(SubjectData& subject);
Status runCoOptimise(SubjectData& subject);
/** Measures what each optional part of the trained avatar is worth; what does not pay is left out of the file. */
Status runEvidence(SubjectData& subject);
Status runPackage(SubjectData& subject);
Status runPoseFit(SubjectData& subject);
Status runReport(SubjectData& subject);

}  // namespace dpl
