// SPDX-License-Identifier: Apache-2.0
// Poses of an avatar from what a platform tracks of a person: cleaned, retargeted, smoothed, extrapolated to the time of a picture, and
// faded over gaps. Formulas: docs/reference/driving.md.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/motion/arm_guard.h"
#include "sdk/motion/pose_fade.h"
#include "sdk/motion/track_driver.h"
#include "sdk/motion/track_source.h"

namespace dpl {

enum class TrackerState : uint32_t { Waiting = 0, Tracking = 1, Lost = 2 };

struct TrackerStatus {
    TrackerState state = TrackerState::Waiting;
    uint32_t drivenJoints = 0, framesTaken = 0, framesDropped = 0;
    float rateHz = 0, noiseDeg = 0, delayS = 0, predictedS = 0;  // as DplTrackerStatus
};

/** Not thread safe. It points into itself, so it stays where it was made. */
class Tracker {
public:
    /** rest: of the format, or without joints. Errors: TrackSource::create, TrackDriver::create. */
    static Result<std::unique_ptr<Tracker>> create(std::vector<JointData> joints, TrackFormat format, const TrackerOptions& options,
                                                   const TrackFrame& rest);
    Tracker(const Tracker&) = delete;
    Tracker& operator=(const Tracker&) = delete;

    /** InvalidArgument: spans that do not fit the format. CorruptData: the frame contradicts itself or the rest; it is dropped. */
    Status add(const TrackFrame& frame);

    /** Arms are kept out of this body from now on. */
    void guardArms(const BodyShape& body) { guard_.emplace(body, joints_); }

    /** pose: the one beneath, of the rig's size; replaced by what shall be shown at timeNs. `holdsPlace`: where nothing is tracked, the
     * root stays where it was shown last instead of that of the pose. */
    void pose(int64_t timeNs, bool holdsPlace, Pose& pose);

    const TrackerStatus& status() const { return status_; }
    /** Joints of a frame. */
    size_t trackedCount() const { return source_->jointCount(); }

private:
    Tracker(std::vector<JointData> joints, const TrackerOptions& options);
    void pushArms(float stepS, Pose& pose);
    void describe(float aheadS);

    std::vector<JointData> joints_;
    std::unique_ptr<TrackSource> source_;
    std::unique_ptr<TrackDriver> driver_;  // refers to both above
    StreamClock clock_;
    uint32_t lateInARow_ = 0;  // frames before the last one that rise among themselves
    int64_t lastLateNs_ = 0;
    std::optional<ArmGuard> guard_;
    ArmGuard::Pushes pushed_{};
    CleanFrame frame_;

    int64_t shownNs_ = 0;
    bool shown_ = false;
    Vec3f rootShown_{0};
    PoseFade fade_;
    std::vector<uint32_t> drivers_;  // by joint, then of the root
    std::vector<float> sorted_;
    TrackerStatus status_;
};

}  // namespace dpl
