// SPDX-License-Identifier: Apache-2.0
// What clothes remember along a scan's film, and along a move.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/judging/coach/move_poses.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/frame_table.h"

namespace dpl {

/** Times of those of a scan's frames that move, seconds. rows: of the scan. */
std::vector<double> movingTimesS(const Scan& scan, std::span<const size_t> rows);

/** Sets Pose::before of moving frames by what came before them in the film (rememberFilm); that of the others is zero. poses: one a row. */
void rememberPoses(const Scan& scan, std::span<const size_t> rows, const MotionModeData& motion, std::span<Pose> poses);
/** The same for the poses of a set of frames. */
void rememberFrames(const Scan& scan, const MotionModeData& motion, FrameSet& set);
/** The same for the poses of all frames of a scan, in its order. */
void rememberPoses(const Scan& scan, const MotionModeData& motion, std::span<Pose> poses);

/** The same for a poses file of the scan, one pose a frame. A fitted pose remembers the same as the pose that it was fitted from. */
void rememberPoses(const Scan& scan, const MotionModeData& motion, PosesFile& file);

/** The poses of a move that goes round and round: clothes remember a first round. */
std::vector<Pose> posesInLoop(const MotionModeData& motion, const MoveClip& move);

}  // namespace dpl
