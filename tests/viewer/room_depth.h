// SPDX-License-Identifier: Apache-2.0
// Depth of the room as a depth buffer of four samples holds it, computed on the CPU.
#pragma once

#include <vector>

#include "platform/common/room_mesh.h"
#include "sdk/math/camera.h"

namespace dpl::test {

/** View z of the farthest of the four samples of each pixel, metres; 0 where a sample sees nothing. Rows without padding. */
std::vector<float> roomDepthM(const platform::RoomPlan& plan, const Camerad& camera);

}  // namespace dpl::test
