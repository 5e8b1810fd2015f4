// SPDX-License-Identifier: Apache-2.0
// Makes the bones of one skeleton follow those of another, whatever their rest poses. Recorded clips and live trackers share it.
//
// D is the world rotation of a bone since its rest pose. Rest poses differ (T-pose or A-pose, straight or bent fingers). Each target bone k
// therefore has a constant rotation A_k that turns its rest direction to that of the source bone:   D_target = D_source · A_k.
// Limbs then point exactly where those of the source point. Torso, head, shoulders and feet use A = 1, because both skeletons stand upright
// at rest; this keeps the target's own build.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/avatar/humanoid.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** The rotation that turns up and forward of a skeleton at rest to +Y and +Z. Both are snapped to an axis, so a small lean stays. Empty if
 *  the skeleton does not stand. at: positions of its joints. */
std::optional<Quatf> uprightFrom(const BoneMap& bones, std::span<const Vec3f> at);

/** Whether both skeletons have hips, and both upper legs or both upper arms. Unsupported: no; the text lists the joints of the one that
 *  lacks them. sourceName: of the motion or tracker. */
Status checkCommonBones(std::string_view sourceName, std::span<const JointData> source, const BoneMap& sourceBones,
                        std::span<const JointData> target, const BoneMap& targetBones);

class BoneFollower {
public:
    /** A target joint that follows a source joint. */
    struct Driven {
        size_t target = 0, source = 0;
        Quatf align = Quatf(1, 0, 0, 0);   // A_k
        Vec3f restDirection{0};            // direction of the target bone at rest, unit; zero: none
        std::optional<size_t> sourceNext;  // source joint that the bone points to; set if the direction must match exactly
    };

    /** source: joints with their parents; their positions at rest, turned upright, are sourceRest. The spans must outlive this. */
    BoneFollower(std::span<const JointData> source, const BoneMap& sourceBones, std::span<const Vec3f> sourceRest,
                 std::span<const JointData> target);

    std::span<const Driven> driven() const { return driven_; }  // by rising target
    const BoneMap& targetBones() const { return bones_; }
    Driven* drivenBone(std::string_view bone);
    /** Ratio of leg lengths, target to source. Without legs: of the heights of the hips above the lowest joint. */
    float travelScale() const;

    /** Replaces the local rotations of driven joints. rotations: D of the source's joints. positions: of the source's joints, so that bones
     *  point exactly to them although joints between them bend too; empty: rotations alone decide. tracked: by source joint, whether it may
     *  drive; empty: all do. */
    void pose(std::span<const Quatf> rotations, std::span<const Vec3f> positions, std::span<const uint8_t> tracked,
              std::span<Quatf> localRotations);
    /** World positions of the target's joints after pose(), with its root at rest. */
    std::span<const Vec3f> positions() const { return positions_; }

private:
    void mapBones();
    void alignLimb(const std::string& side, size_t limb);
    void alignPalm(const std::string& side);
    Driven* drivenBy(size_t targetJoint);

    std::span<const JointData> source_, target_;
    const BoneMap& sourceBones_;
    std::span<const Vec3f> sourceRest_;
    BoneMap bones_;
    std::vector<Driven> driven_;
    std::vector<Quatf> world_;
    std::vector<Vec3f> positions_;
};

}  // namespace dpl
