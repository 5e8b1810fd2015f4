// SPDX-License-Identifier: Apache-2.0
// Reads frames of a tracker's skeleton: cleans them, checks them, and gives the rotation of each joint since a standing rest pose.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/motion/bone_follower.h"
#include "sdk/motion/track_format.h"

namespace dpl {

/** One frame as a program gives it; the spans are read during the call. */
struct TrackFrame {
    int64_t timeNs = 0;
    std::span<const float> rotations;   // 4 a joint, x y z w; empty: positions only
    std::span<const float> positions;   // 3 a joint, metres
    std::span<const float> confidence;  // 1 a joint; empty: all are tracked
};

/** A frame in right-handed axes with +Y up. */
struct CleanFrame {
    std::vector<Quatf> rotations;  // unit; of joints that are not tracked: identity
    std::vector<Vec3f> positions;
    std::vector<uint8_t> tracked;
};

/** Joints whose confidence is below 0.5, or that have a number that is not finite, a rotation without length or a place beyond 1 km, are
 *  not tracked. The spans of the frame must fit the format. `out` is reused. */
void cleanFrame(TrackFormat format, const TrackFrame& frame, CleanFrame& out);

/** Of the formats that give world rotations and positions of bones. */
class TrackSkeleton {
public:
    /** rest: as a frame; without joints: VRM's T-pose. CorruptData: not a standing person, or left and right are swapped. InvalidArgument:
     * a joint that is needed is not finite. */
    static Result<TrackSkeleton> create(TrackFormat format, const TrackFrame& rest);

    std::span<const JointData> joints() const { return joints_; }  // without parents
    const BoneMap& bones() const { return bones_; }
    std::span<const Vec3f> rest() const { return rest_; }  // upright, facing +Z

    /** Turns the rotations of a frame into those since rest (D of bone_follower.h), in place. CorruptData: swapped sides, or lengths of
     *  another skeleton. */
    Status read(CleanFrame& frame) const;

private:
    bool isSwapped(const CleanFrame& frame) const;
    Status checkLengths(const CleanFrame& frame) const;

    std::vector<JointData> joints_;
    BoneMap bones_;
    std::vector<Vec3f> rest_;
    std::vector<Quatf> uprightFromJoint_;  // D = rotation of a frame · this
    bool knowsLengths_ = false;
};

}  // namespace dpl
