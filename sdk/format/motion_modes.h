// SPDX-License-Identifier: Apache-2.0
// Motion modes as data: checks of their arrays, and their streams in an avatar file (docs/formats/avatar.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr uint32_t kMaxMotionJoints = 12, kMaxMotionHolds = 3, kMaxMotionLags = 3, kMaxMotionGroups = 8;
constexpr float kMaxMotionHoldS = 3600, kMinMotionLagS = 0.01f, kMaxMotionLagS = 60;

/** Refuses arrays that do not fit one another or the rig, joints that are not listed in rising order, groups without columns,
 *  still rotations that are no unit quaternions, ranges and holds that are negative or too large, and numbers that are not finite
 *  (CorruptData). With good numbers no pose
 *  gives a coefficient that is not finite. */
Status checkMotionModes(const MotionModeData& motion, size_t jointCount);

/** The streams of a file, little-endian. Bytes: owned when written, borrowed when read. */
template <class Bytes>
struct MotionStreams {
    Bytes groups;  // u32 columns, f32 reach: 8 bytes a group
    Bytes still;   // f32 x 4 a joint
    Bytes ranges;  // f32 x 2 a joint
    Bytes modes;   // f32, K' rows of 1 + J inputs for each hold, then 6·J numbers for each lag
};

/** The motion modes must have passed checkMotionModes. */
MotionStreams<std::vector<uint8_t>> encodeMotionModes(const MotionModeData& motion);

/** Fills `groups`, `still`, `rangeRad` and `modes`. head: everything else. Checks the length of each stream before it allocates; the caller
 * checks the values by checkMotionModes. */
Result<MotionModeData> decodeMotionModes(const MotionStreams<std::span<const uint8_t>>& streams, MotionModeData head);

/** A hash of all that decides what a state of these motion modes means. */
uint64_t hashOfMotionModes(const MotionModeData& motion);

/** Appends the columns of motion modes to correctives without any; their nodes are zero. */
void addMotionModes(PoseCorrectiveData& correctives, MotionModeData motion);
/** Removes the motion modes and their columns of the nodes. */
void dropMotionModes(PoseCorrectiveData& correctives);

}  // namespace dpl
