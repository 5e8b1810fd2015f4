// SPDX-License-Identifier: Apache-2.0
// Scores of a finished avatar on the frames of one split, for the report and `doppel evaluate`.
#pragma once

#include <vector>

#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/frame_table.h"

namespace dpl {

/** The label baseline: one colour a label, from training frames. */
Result<LabelColours> gatherLabelColours(const FrameTable& table);

/** Draws each frame of `set` in the poses found for it, and scores both pictures and both floors. poses: one a frame of the scan.
 *  withPictures: keep what the page shows: truth, render and difference, as pictures and on the surface. Errors: a picture cannot be read;
 * Cancelled. */
Result<std::vector<HeldOutFrame>> scoreFrames(const LabelColours& labelColours, const FrameSet& set, const AvatarData& avatar,
                                              AvatarView& view, const PosesFile& poses, bool withPictures, Jobs& jobs);

/** Two lines a kind of frame: scores inside the mask with and without pose fit, and scores over the union. `what`: "held-out",
 * "validation". */
std::string scoreLines(const std::vector<HeldOutFrame>& frames, const char* what);

}  // namespace dpl
