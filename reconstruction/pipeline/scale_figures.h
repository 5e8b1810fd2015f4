// SPDX-License-Identifier: Apache-2.0
// Scores of an avatar that is drawn at other sizes than it was trained at.
#pragma once

#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/progress.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/report.h"

namespace dpl {

/** Adds masked PSNR of held-out frames drawn at ×0.5 to ×4. Picture and truth are area-averaged to one size before they are compared: to ×1
 *  those drawn no smaller, and all of them to ×0.5. Averaging hides error, so figures at two sizes do not compare.
 *  The truth of a frame is the finest picture that the scan has of it (hires/ of docs/formats/scan.md, read for this only); its mask knows
 *  how much of an outline pixel the person covers. Where no frame has one, the truth is the frame with its mask. */
Status addScaleFigures(const std::filesystem::path& scan, Progress& progress, AvatarView& view, const FrameSet& heldOut,
                       const PosesFile& poses, ReportData& data);

}  // namespace dpl
