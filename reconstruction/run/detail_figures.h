// SPDX-License-Identifier: Apache-2.0
// How much fine detail of the subject an avatar shows, against pictures finer than those of its training.
#pragma once

#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/progress.h"

namespace dpl {

/** Adds to `data` the correlation of fine detail (report/detail.h) of held-out frames drawn at twice the size, in the poses after the pose
 *  fit, with the scan's finest pictures of them: of the whole subject and of each label. Adds nothing when the scan has no finer pictures.
 */
Status addDetailFigures(const Scan& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses, ReportData& data);

/** Adds the contrast that close-ups keep of printed bars (report/bar_contrast.h), by their width: held-out close-ups drawn in the poses
 * after the pose fit. Adds nothing when the scan's truth tells of no bars. */
Status addBarFigures(const Scan& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses, ReportData& data);

}  // namespace dpl
