// SPDX-License-Identifier: Apache-2.0
// The fingers of a body: their joints by humanoid bone, their tips by the mesh.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "reconstruction/subject/body/body_model.h"

namespace dpl {

/** The joints of one finger, palm first. */
using FingerJoints = std::array<uint32_t, 3>;

/** A finger in the order of handKeypointNames() (0 the left thumb … 9 the right pinky), or nothing where the body lacks one of its three
 *  joints. */
std::optional<FingerJoints> fingerJoints(const BodyModel& body, size_t finger);

/** Keypoints of the fingers that the body has, in the order of handKeypointNames(): three joints and the tip, which is the vertex of the
 *  last bone that lies farthest along it. A finger without such a vertex is left out. */
std::vector<BodyKeypoint> deriveHandKeypoints(const BodyModel& body);

}  // namespace dpl
