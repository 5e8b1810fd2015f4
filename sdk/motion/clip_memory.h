// SPDX-License-Identifier: Apache-2.0
// What clothes remember along a clip, as a function of the clip and the time alone: any order and rate of calls gives the same bytes.
#pragma once

#include <vector>

#include "sdk/avatar/motion_state.h"

namespace dpl {

/** The states of a clip on a fixed grid of 60 a second (coarser for clips of more than ten minutes), of which it keeps one in 60. A call
 *  replays at most 59 grid steps; calls whose times rise replay what lies between them. One thread at a time. at() does not allocate. */
class ClipMemory {
public:
    /** Replays the clip once. The clip must have passed checkClip, the motion modes checkMotionModes. All three must outlive this. Without
     *  motion modes it keeps nothing. */
    ClipMemory(const ClipData& clip, std::span<const JointData> joints, const MotionModeData& motion);

    /** What is held `timeS` seconds after the first key (Pose::before of samplePose): before the first key nothing, after the last one what
     *  is left. loop: timeS must lie within the clip, and what is held is that of a clip which has always been playing. */
    MotionMemory at(double timeS, bool loop);

private:
    const ClipData* clip_;
    std::span<const JointData> joints_;
    const MotionModeData* motion_;
    double durationS_ = 0, stepS_ = 0;
    std::vector<MotionState> kept_;  // at every 60th grid point from the start, without a loop
    MotionState end_;                // at the last key, without a loop
    MotionState round_;              // what a loop adds at its start
    size_t cursorStep_ = 0;          // grid point of
    MotionState cursor_;
    Pose scratch_;

    void setRound();
    /** Moves the cursor on to a grid point that does not lie before it. */
    void advanceTo(size_t step);
    void setCursor(size_t step, const MotionMemory& before);
};

}  // namespace dpl
