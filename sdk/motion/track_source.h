// SPDX-License-Identifier: Apache-2.0
// What a platform's frames tell of a person. One class a format knows its axes, its rest pose and what its frames lack.
#pragma once

#include <memory>

#include "sdk/core/result.h"
#include "sdk/motion/track_skeleton.h"

namespace dpl {

/** One frame as a program gives it; the spans are read during the call. */
struct TrackFrame {
    int64_t timeNs = 0;
    std::span<const float> rotations;   // 4 a joint, x y z w; empty: positions only
    std::span<const float> positions;   // 3 a joint, metres
    std::span<const float> confidence;  // 1 a joint; empty: all are tracked
};

class TrackSource {
public:
    /** rest: of the format, or without joints. InvalidArgument: there is no such format, it needs a rest or takes none, or sizes do not
     * fit. Other errors: TrackSkeleton::create. */
    static Result<std::unique_ptr<TrackSource>> create(TrackFormat format, const TrackFrame& rest);
    virtual ~TrackSource() = default;

    /** InvalidArgument: spans that do not fit the format. */
    Status checkSizes(const TrackFrame& frame) const;
    /** Reads a frame whose sizes fit. `out` has rotations since rest by joint of skeleton(), or without a skeleton the 53 poses of
     *  HeadAndHands. CorruptData: the frame contradicts itself or the rest pose. */
    virtual Status read(const TrackFrame& frame, CleanFrame& out) = 0;

    /** Bones and their rest pose. Null: a head and two hands, which have none. */
    virtual const TrackSkeleton* skeleton() const { return nullptr; }
    virtual bool travels() const { return true; }    // false: places are relative to the hips, and read() gives none
    virtual bool tellsLegs() const { return true; }  // false: legs follow from where the hips are
    size_t jointCount() const { return table_.size(); }

protected:
    explicit TrackSource(std::span<const TrackedJoint> table) : table_(table) {}
    /** Joints whose confidence is below 0.5, or that have a number that is not finite, a rotation without length or a place beyond 1 km,
     *  are not tracked. The spans of the frame must fit the format. `out` is reused. CorruptData: many joints lie 1 to 100 km away. */
    Status clean(const TrackFrame& frame, CleanFrame& out) const;
    enum class RestPose { Needed, Optional, None };

    std::span<const TrackedJoint> table_;

private:
    virtual RestPose restPose() const { return RestPose::Needed; }
    virtual bool hasRotations() const { return true; }
    /** To right-handed axes with +Y up. */
    virtual void turnAxes(Quatf&, Vec3f&) const {}
    virtual Status start(const CleanFrame& rest) = 0;
};

}  // namespace dpl
