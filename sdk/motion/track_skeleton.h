// SPDX-License-Identifier: Apache-2.0
// Reads frames of a tracker's skeleton: checks them, and gives the rotation of each joint since a standing rest pose.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/motion/bone_follower.h"
#include "sdk/motion/track_format.h"

namespace dpl {

/** A frame in right-handed axes with +Y up. */
struct CleanFrame {
    std::vector<Quatf> rotations;  // unit; of joints that are not tracked: identity
    std::vector<Vec3f> positions;
    std::vector<uint8_t> tracked;
};

/** Of the formats that give world rotations and positions of bones. */
class TrackSkeleton {
public:
    /** table: joints of the format. rest: a frame of it; without joints: VRM's T-pose. CorruptData: not a standing person, or left and
     * right are swapped. InvalidArgument: a joint that is needed is not finite. */
    static Result<TrackSkeleton> create(std::span<const TrackedJoint> table, const CleanFrame& rest);

    std::span<const JointData> joints() const { return joints_; }  // without parents
    const BoneMap& bones() const { return bones_; }
    std::span<const Vec3f> rest() const { return rest_; }  // upright, facing +Z
    bool knowsLengths() const { return knowsLengths_; }    // of the person's bones: a rest pose was given

    /** Turns the rotations of a frame into those since rest (D of bone_follower.h), in place. CorruptData: swapped sides, or lengths of
     *  another skeleton. */
    Status read(CleanFrame& frame) const;

private:
    bool isSwapped(const CleanFrame& frame) const;
    Status checkLengths(const CleanFrame& frame) const;
    float scaleOf(const CleanFrame& frame, std::span<const Vec3f> rest, std::vector<float>& ratios) const;

    std::vector<JointData> joints_;
    BoneMap bones_;
    std::vector<Vec3f> rest_;
    std::vector<Quatf> uprightFromJoint_;  // D = rotation of a frame · this
    bool knowsLengths_ = false;
};

}  // namespace dpl
