// SPDX-License-Identifier: Apache-2.0
// Moves an avatar's joints by what a TrackSource tells: by bones, or by a head and two hands. A driver smooths what it takes; gaps and
// fades are the tracker's.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/motion/bone_follower.h"
#include "sdk/motion/hand_follower.h"
#include "sdk/motion/track_channel.h"
#include "sdk/motion/track_source.h"

namespace dpl {

struct TrackerOptions {
    bool raw = false;        // neither smoothed nor extrapolated
    bool keepPlace = false;  // the avatar stands where the person stands; false: it starts above the origin, and travel is scaled by legs
    bool inPlace = false;    // no travel; poses of OpenxrHands are in the avatar's own space
};

class TrackDriver {
public:
    /** joints and source must outlive it. Unsupported: the avatar lacks the bones that the source moves; checkCommonBones. */
    static Result<std::unique_ptr<TrackDriver>> create(const TrackSource& source, std::span<const JointData> joints,
                                                       const TrackerOptions& options);
    virtual ~TrackDriver() = default;

    /** Takes what the source has read, at clock.lastNs. */
    virtual void take(const CleanFrame& frame, const StreamClock& clock) = 0;
    /** The pose beneath becomes the person's at clock.pictureNs. drivers: by joint, then of the root, raised from 0 where the person
     * drives. Returns by how many seconds the pose is extrapolated. */
    virtual float show(const StreamClock& clock, Pose& pose, std::span<uint32_t> drivers) = 0;
    /** Puts what the source does not tell below what it does. After show(), once the root is known. */
    virtual void complete(Pose&, std::span<uint32_t>) {}

    void restart();
    std::span<const TrackChannel<Quatf>> turns() const { return turns_; }

protected:
    TrackDriver(std::span<const JointData> joints, const TrackerOptions& options) : joints_(joints), options_(options) {}

    std::span<const JointData> joints_;
    TrackerOptions options_;
    std::vector<TrackChannel<Quatf>> turns_;
    std::vector<TrackChannel<Vec3f>> places_;
    std::optional<Vec3f> origin_;  // of the hips or the head in the tracker's space
};

/** Of sources with a skeleton. */
class BoneDriver final : public TrackDriver {
public:
    BoneDriver(const TrackSource& source, std::span<const JointData> joints, const TrackerOptions& options);
    const BoneMap& targetBones() const { return follower_.targetBones(); }
    void findScale();
    void take(const CleanFrame& frame, const StreamClock& clock) override;
    float show(const StreamClock& clock, Pose& pose, std::span<uint32_t> drivers) override;
    void complete(Pose& pose, std::span<uint32_t> drivers) override;

private:
    Vec3f rootFor(float stepS, const CleanFrame& frame);
    void measureLegs(const CleanFrame& frame);
    void standBelowHips(Pose& pose, std::span<uint32_t> drivers);

    const TrackSource& source_;
    const TrackSkeleton& skeleton_;
    BoneFollower follower_;
    std::vector<uint8_t> wasTracked_;  // by source joint
    std::vector<Quatf> local_;         // as the last frames had them
    float scale_ = 0;                  // of travel; 0: not known yet
    std::optional<float> floor_;       // lowest place of feet, or where the source tells no legs, height of standing hips
    std::vector<uint8_t> anew_;        // scratch
    std::vector<Quatf> world_;
    std::vector<Vec3f> at_;
};

/** Of a head and two hands. */
class HandDriver final : public TrackDriver {
public:
    HandDriver(std::span<const JointData> joints, const TrackerOptions& options);
    void take(const CleanFrame& frame, const StreamClock& clock) override;
    float show(const StreamClock& clock, Pose& pose, std::span<uint32_t> drivers) override;

private:
    Quatf headingOf(const Quatf& head);

    HandFollower follower_;
    float stanceYawRad_ = 0;
    bool stanceKnown_ = false;
    std::vector<uint8_t> driven_;  // scratch
};

}  // namespace dpl
