// SPDX-License-Identifier: Apache-2.0
// How much fine detail of the subject an avatar shows, against pictures finer than those of its training.
#pragma once

#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/progress.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/report.h"

namespace dpl {

/** Adds to `data` the correlation of fine detail (report/detail.h) of held-out frames drawn at twice the size, in the poses after the pose
 *  fit, with the scan's finest pictures of them: of the whole subject and of each label. Adds nothing when the scan has no finer pictures.
 */
Status addDetailFigures(const Scan& scan, Progress& progress, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses,
                        ReportData& data);

}  // namespace dpl
