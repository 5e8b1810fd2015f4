// SPDX-License-Identifier: Apache-2.0
// The ladder: scores an avatar on frames of a synthetic scan while the truth replaces one stage after the other, so that the figures tell
// what pose, shape, light and texture cost. It only measures; docs/reference/metrics.md.
#pragma once

#include <optional>
#include <span>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/package/poses_file.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct LadderInput {
    const Scan& scan;
    std::span<const Camerad> cameras;  // of Scan::frames, metres
    const AvatarData& avatar;
    const PosesFile& poses;  // of this avatar and scan, one a frame
};

/** Measures the ladder. None when the scan has no truth, or no still frame that it was trained on. Memory: a few pictures. Deterministic.
 *  Errors: a file of the truth is damaged; Cancelled. */
Result<std::optional<Ladder>> measureLadder(const LadderInput& input, Jobs& jobs);

}  // namespace dpl
