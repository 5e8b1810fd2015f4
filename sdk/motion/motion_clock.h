// SPDX-License-Identifier: Apache-2.0
// What an avatar's clothes remember while an app drives it, by the time stamps that the app gives.
//
//   setters: a pose and its time ─► show(), once a picture ─► Pose::before
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/avatar/motion_state.h"
#include "sdk/core/result.h"

namespace dpl {

/** After a gap of more than kMotionGapS, or when time runs backwards, what was remembered fades within
 *  kMotionFadeS. */
constexpr double kMotionGapS = 5, kMotionFadeS = 0.25;

/** Pure bookkeeping: one thread at a time, nothing allocates but save(). All calls of one clock must name the same motion modes, which have
 *  passed checkMotionModes. */
class MotionClock {
public:
    /** The next pose to be shown is of this time, ns of any one clock. */
    void setTime(int64_t timeNs) { timed_ = true, timeNs_ = timeNs; }
    /** The next pose knows no time, or Pose::before is set already. */
    void setUntimed() { timed_ = false; }
    /** Call it when a pose is shown or asked for, with the pose of the last setter, which must have passed checkPose. Sets Pose::before of
     * a pose that has a time. The state advances when that time is new; a pose that is shown twice, or replaced at the same time, is drawn
     *  with the same memory. */
    void show(const MotionModeData& motion, Pose& pose);
    /** Forgets all. The pose that is shown stays, with nothing held. */
    void settle(Pose& pose);

    /** The clock as bytes of a fixed size for these motion modes: at most kMaxSavedMotionBytes. */
    std::vector<uint8_t> save(const MotionModeData& motion) const;
    /** Restores save(). The pose is then drawn with what that one held. InvalidArgument: other bytes, those of an avatar with other motion
     *  modes, or numbers that no motion gives. */
    Status restore(const MotionModeData& motion, std::span<const uint8_t> bytes, Pose& pose);

private:
    MotionMemory fresh_;    // before the pose that was shown last, since the last jump
    MotionMemory carried_;  // what is left of the time before that jump
    MotionState shown_;     // in that pose, of fresh_ alone
    int64_t shownNs_ = 0, timeNs_ = 0;
    double fadeLeftS_ = 0;  // carried_ fades to nothing within this time
    bool timed_ = false;    // the pose to show has a time: timeNs_
    bool running_ = false;  // shown_ is of the time shownNs_

    void advance(const MotionModeData& motion);
};

constexpr size_t kMaxSavedMotionBytes = 40 + 2 * sizeof(MotionMemory) + sizeof(MotionState);

}  // namespace dpl
