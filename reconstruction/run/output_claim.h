// SPDX-License-Identifier: Apache-2.0
// OUT/run.json says whose run an output folder holds, so that another scan does not replace an avatar by accident.
#pragma once

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/reconstruct.h"

namespace dpl {

/** Refuses an output folder that holds the run of another scan, unless options.replace. It is the same scan if it lies where it lay, or
 *  shares a picture with the one that was there. Before an import pictures are not known, so then it must lie where it lay. A scan that
 *  does not exist passes: whoever reads it names it. */
Status checkOutputIsFree(const ReconstructOptions& options);

/** Writes run.json: where the scan lies, and the hashes of its pictures. hashes: of hashFrames(scan). */
Status claimOutput(const ReconstructOptions& options, const Scan& scan, const std::vector<FrameHashes>& hashes);

}  // namespace dpl
