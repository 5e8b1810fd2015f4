// SPDX-License-Identifier: Apache-2.0
// Scores of an avatar drawn at other sizes than those of its training.
#pragma once

#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/progress.h"

namespace dpl {

/** Adds to `data` the masked PSNR of held-out frames drawn at ×0.5 to ×4. Picture and truth are area-averaged to the same size before the
 *  comparison. Every drawing is compared at ×0.5, and those drawn at ×1 or larger also at ×1. Averaging hides error, so figures at
 *  different comparison sizes are not comparable.
 *  The truth of a frame is its finest picture in the scan (hires/ of docs/formats/scan.md, read for this only), whose mask holds the
 *  partial coverage of outline pixels. If no frame has such a picture, the truth is the frame with its mask. */
Status addScaleFigures(const std::filesystem::path& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses,
                       ReportData& data);

}  // namespace dpl
