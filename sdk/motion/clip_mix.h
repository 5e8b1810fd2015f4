// SPDX-License-Identifier: Apache-2.0
// Several clips at once: cross-fades, layers over a part of the body, and walks that go on from one clip to the next.
// Formulas: docs/reference/mixing.md.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Where something stands on the ground and which way it faces: it is turned about the world's +Y, then shifted. */
struct GroundPlace {
    double headingRad = 0;  // a quarter turn takes +Z to +X
    Vec2d shiftM{0};        // along x and z

    bool none() const { return headingRad == 0 && shiftM == Vec2d(0); }
};
/** Moved by b, then by a. */
GroundPlace operator*(const GroundPlace& a, const GroundPlace& b);
GroundPlace inverse(const GroundPlace& place);
/** `place` as often as `rounds` says, a whole number; below 0: its inverse. In closed form, so any number takes the same time. */
GroundPlace repeated(const GroundPlace& place, double rounds);

/** A clip within a mix. */
struct ClipLayer {
    const ClipData* clip = nullptr;  // has passed checkClip
    double timeS = 0;                // from its first key
    float weight = 1;
    uint32_t joint = 0;    // the layer moves this joint and all below it; 0: the whole body and the root's translation
    bool loops = false;    // the time wraps around; else it is clamped
    bool travels = false;  // with loops: each round starts where the round before ended
    GroundPlace place;     // moves the whole clip
};

/** The place for `layer` at which its root stands where that of `before` stands, each at its own time. Both then face alike, in the mean of
 *  the second around that time: hips sway as they walk. layer.place does not count. The layers must be valid (ClipMix::check). */
GroundPlace placeAfter(const ClipLayer& before, const ClipLayer& layer, std::span<const JointData> joints);

/** Mixes layers into a pose. It keeps its memory, so a warm mix allocates nothing. One thread at a time. */
class ClipMix {
public:
    /** InvalidArgument: no layers; a time, weight or place that is not finite, or a weight below 0; layers of the whole body do not come
     *  first, or weigh nothing. NotFound: no such joint. The text names the layer by its number. */
    static Status check(std::span<const ClipLayer> layers, std::span<const JointData> joints);

    /** Layers of the same joint that follow one another are one group: each counts by its share of their weights. The first group is the
     *  pose; a later one replaces, in its part of the body, what the groups before it gave, by the sum of its weights, at most 1. The
     *  result knows no time (Pose::before). Errors of check(); `pose` then stays. */
    Status mix(std::span<const ClipLayer> layers, std::span<const JointData> joints, Pose& pose);

private:
    void average(std::span<const ClipLayer> group, double total, std::span<const JointData> joints);
    void put(uint32_t joint, float share, std::span<const JointData> joints, Pose& pose);

    Pose sampled_, average_;
    std::vector<uint8_t> moved_;  // by joint: the group moves it
};

}  // namespace dpl
