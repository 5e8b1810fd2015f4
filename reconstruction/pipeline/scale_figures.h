// What an avatar is worth at other sizes than it was trained at.
#pragma once

#include "reconstruction/package/poses_file.h"
#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/report/report.h"

namespace dpl {

/** Adds masked PSNR of held-out frames drawn at ×0.5 to ×4, pictures and truth area-averaged to one size: to ×1 those drawn no smaller, and all
 *  to ×0.5 (averaging hides error, so figures at two sizes do not compare).
 *  One truth for all sizes of a frame: the finest that the scan has (hires/ of docs/formats/scan.md, read for this only), because its outline
 *  pixels know how much of them the person covers; where no frame has one, the frame and its yes-or-no mask. */
Status addScaleFigures(const SubjectData& subject, Progress& progress, const std::vector<uint8_t>& avatarBytes, const PosesFile& poses, ReportData& data);

}  // namespace dpl
