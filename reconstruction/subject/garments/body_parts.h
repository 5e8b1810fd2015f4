// SPDX-License-Identifier: Apache-2.0
// Which part of the body moves its joints and triangles: an arm, a leg.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** The part of each joint: that of the nearest named bone (sdk/avatar/humanoid.h) on the way up, itself included; 0 where none is named. */
std::vector<uint8_t> partsOfJoints(std::span<const JointData> joints, const std::map<std::string_view, uint8_t>& partOfBone);

/** The part that moves most of each triangle; the lower part wins ties. ofJoint: values below 8. */
std::vector<uint8_t> partsOfTriangles(const MeshData& mesh, std::span<const uint8_t> ofJoint);

}  // namespace dpl
