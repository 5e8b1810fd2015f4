// SPDX-License-Identifier: Apache-2.0
// How well an avatar shows each part of the subject that the scan labels: hair, skin, each garment.
#pragma once

#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/progress.h"

namespace dpl {

/** Adds to `data` the masked PSNR and the overlap of outlines of each label (report/label_score.h), means over held-out frames of a kind in
 * the poses after the pose fit. Adds nothing for frames without labels. */
Status addLabelFigures(const Scan& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses, ReportData& data);

}  // namespace dpl
