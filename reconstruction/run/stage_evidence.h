// SPDX-License-Identifier: Apache-2.0
// The stage evidence measures how much each optional part improves the avatar. The trained avatar is trained on for a short while, whole
// and again without each part, so that what remains makes up for the part as well as it can. The public SDK draws validation frames with
// each of these avatars, and the pictures are scored. A validation frame is drawn in its registered pose after a pose fit, which moves
// joints and root only, to the avatar that is judged; it starts where a fit to the trained avatar ended. A part must gain a fixed amount,
// and more the larger it is. A scan that is too small for a validation split is judged on training frames. Held-out frames are not used.
#pragma once

#include "reconstruction/judging/evidence/evidence_file.h"
#include "reconstruction/run/graph.h"
#include "reconstruction/run/preset.h"
#include "reconstruction/run/stage_assemble.h"
#include "reconstruction/training/trainer/retrain.h"

namespace dpl {

struct MeasuredParts {
    std::vector<PartEvidence> parts;
};

template <>
struct StageOf<MeasuredParts> {
    static constexpr StageName kName{"evidence", 16};
    static constexpr const char* kPriors[] = {"input/cameras",   "input/capture",        "judging/evidence", "subject/garments",
                                              "subject/surface", "training/correctives", "training/trainer"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<MeasuredParts> read(StageInputs& in, const std::filesystem::path& folder);
};

/** Trains an avatar, from which parts may have been taken, on for a short while. The stage scores avatars after this, and packaging does
 * the same without the parts that did not pay: what ships is what was judged. parts: those that may still learn. A stopped run goes on from
 * the file `checkpoint`, which the caller removes. */
Result<AvatarData> trainedOn(AvatarData avatar, const RetrainParts& parts, const AssembledAvatar& assembled, const RunSettings& settings,
                             Jobs& jobs, const std::filesystem::path& checkpoint, Progress& progress);

}  // namespace dpl
