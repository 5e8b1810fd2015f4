// SPDX-License-Identifier: Apache-2.0
// Poses of an avatar from what a platform tracks of a person: cleaned, retargeted, smoothed, extrapolated to the time of a picture, and
// faded over gaps. Formulas: docs/reference/driving.md.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/motion/arm_guard.h"
#include "sdk/motion/hand_follower.h"
#include "sdk/motion/one_euro.h"
#include "sdk/motion/pose_fade.h"
#include "sdk/motion/track_points.h"
#include "sdk/motion/track_skeleton.h"

namespace dpl {

struct TrackerOptions {
    bool raw = false;        // neither smoothed nor extrapolated
    bool keepPlace = false;  // the avatar stands where the person stands; false: it starts above the origin, and travel is scaled by legs
    bool inPlace = false;    // no travel; poses of OpenxrHands are in the avatar's own space
};

enum class TrackerState : uint32_t { Waiting = 0, Tracking = 1, Lost = 2 };

struct TrackerStatus {
    TrackerState state = TrackerState::Waiting;
    uint32_t drivenJoints = 0, framesTaken = 0, framesDropped = 0;
    float rateHz = 0, noiseDeg = 0, delayS = 0, predictedS = 0;  // as DplTrackerStatus
};

/** Not thread safe. It points into itself, so it stays where it was made. */
class Tracker {
public:
    /** rest: of the format, or without joints. InvalidArgument: the format needs a rest, or its sizes do not fit. Other errors:
     *  checkCommonBones, TrackSkeleton::create. */
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
    size_t trackedCount() const { return trackedJoints(format_).size(); }

private:
    template <class T>
    struct Channel {
        OneEuro<T> filter;
        int64_t lastNs = 0;
        uint32_t driver = 0;  // counts how often it was acquired; 0: never
    };

    Tracker(std::vector<JointData> joints, TrackFormat format, const TrackerOptions& options);
    Status checkSizes(const TrackFrame& frame) const;
    Status addBones();
    Status addHands();
    template <class T>
    void feed(Channel<T>& channel, const T& value, const FilterLimits& limits, float farthest, bool anew);
    template <class T>
    bool isFresh(const Channel<T>& channel) const;
    template <class T>
    T sample(const Channel<T>& channel);
    void poseBones(Pose& pose);
    void poseHands(Pose& pose);
    void standBelowHips(Pose& pose);
    Vec3f rootFor(float stepS, const CleanFrame& frame);
    void describe();

    std::vector<JointData> joints_;
    TrackFormat format_;
    TrackerOptions options_;
    std::optional<TrackSkeleton> skeleton_;  // of formats that give bones
    std::optional<BoneFollower> follower_;   // of those and of points
    std::optional<HandFollower> hands_;
    std::optional<ArmGuard> guard_;
    ArmGuard::Pushes pushed_{};

    CleanFrame frame_;
    PointBones points_;
    std::vector<uint8_t> wasTracked_;  // by source joint
    std::vector<Quatf> local_;         // as the last frames had them
    std::vector<Channel<Quatf>> turns_;
    std::vector<Channel<Vec3f>> places_;
    int64_t lastNs_ = 0;
    bool any_ = false;  // a frame was taken
    float stepS_ = 0;   // usual time between frames; 0: not known

    float scale_ = 0;              // of travel; 0: not known yet
    std::optional<Vec3f> origin_;  // of the hips or the head in the tracker's space
    std::optional<float> floor_;   // lowest place of feet, or with FbBody height of standing hips
    float stanceYawRad_ = 0;
    bool stanceKnown_ = false;

    int64_t shownNs_ = 0;
    bool shown_ = false;
    Vec3f rootShown_{0};
    PoseFade fade_;
    std::vector<uint32_t> drivers_;  // by joint, then of the root
    std::vector<uint8_t> driven_;    // scratch
    std::vector<Quatf> world_;
    std::vector<Vec3f> at_;
    std::vector<float> sorted_;
    float ahead_ = 0;
    int64_t pictureNs_ = 0;
    TrackerStatus status_;
};

}  // namespace dpl
