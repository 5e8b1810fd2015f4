// SPDX-License-Identifier: Apache-2.0
// What an avatar is worth at other sizes than it was trained at.
#pragma once

#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/report.h"

namespace dpl {

/** Adds masked PSNR of held-out frames drawn at ×0.5 to ×4, pictures and truth area-averaged to one size: to ×1 those drawn no smaller, and
 * all to ×0.5 (averaging hides error, so figures at two sizes do not compare). One truth for all sizes of a frame: the finest that the scan
 * has (hires/ of docs/formats/scan.md, read for this only), because its outline pixels know how much of them the person covers; where no
 * frame has one, the frame and its yes-or-no mask. frames: held out; indices: theirs in poses.frames. */
Status addScaleFigures(const std::filesystem::path& scan, Progress& progress, AvatarView& view, std::span<const TrainFrame> frames,
                       std::span<const size_t> indices, const PosesFile& poses, ReportData& data);

}  // namespace dpl
