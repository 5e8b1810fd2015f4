// SPDX-License-Identifier: Apache-2.0
// The parts of a body by which its joints are listed.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace dpl {

enum class BodyRegion : uint8_t { HeadAndNeck, Trunk, LeftArm, LeftHand, RightArm, RightHand, LeftLeg, RightLeg, Other };
constexpr size_t kBodyRegions = 9;

/** For people, such as "Left arm". */
const char* nameOf(BodyRegion region);

/** Region of each joint: that of its humanoid bone (VRM's name, or ""), or else that of its parent. parents: index of each joint's parent,
 *  smaller than its own; -1: none. Both have one entry for each joint. */
std::vector<BodyRegion> regionsOf(std::span<const std::string> bones, std::span<const int32_t> parents);

}  // namespace dpl
