// SPDX-License-Identifier: Apache-2.0
// The picture of the person that opens the report.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/package/poses_file.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** The avatar alone over white, as the camera saw it that looked most nearly into its face: of still full-body frames, else of moving
 *  ones, else of close-ups. The picture holds the whole person, also where the frame cuts it. cameras (metres) and poses: of Scan::frames.
 *  No picture when no camera sees the whole person before it. */
Result<Portrait> drawPortrait(const Scan& scan, std::span<const Camerad> cameras, const PosesFile& poses, const AvatarData& avatar,
                              AvatarView& view, Jobs& jobs);

}  // namespace dpl
