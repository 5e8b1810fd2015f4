// SPDX-License-Identifier: Apache-2.0
// The joints that platforms' trackers give: their order, their names, and the humanoid bones that they are.
#pragma once

#include <span>
#include <string>

namespace dpl {

/** Numbers are those of DplTrackFormat. */
enum class TrackFormat : uint32_t { Vrm = 0, Unity = 1, ArkitBody = 2, FbBody = 3, OpenxrHands = 4, MediapipePose = 5 };
constexpr uint32_t kTrackFormats = 6;

struct TrackedJoint {
    std::string name;  // in the platform's words
    std::string bone;  // VRM humanoid bone, or "": not used, or not a bone (points)
};

/** The joints of a format in their order; none for another number. The tables live as long as the program. */
std::span<const TrackedJoint> trackedJoints(TrackFormat format);

constexpr size_t kHandJoints = 26;  // XrHandJointEXT
/** Place in OpenxrHands: 0 is the head. side: 0 left, 1 right. joint: XrHandJointEXT. */
constexpr size_t handJoint(size_t side, size_t joint) {
    return 1 + side * kHandJoints + joint;
}
constexpr size_t kPalm = 0, kWrist = 1, kIndexProximal = 7, kMiddleProximal = 12, kLittleProximal = 22;  // XrHandJointEXT

}  // namespace dpl
