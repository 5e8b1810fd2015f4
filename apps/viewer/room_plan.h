// SPDX-License-Identifier: Apache-2.0
// The room around the subjects.
#pragma once

#include "apps/viewer/subject.h"
#include "platform/common/room_mesh.h"

namespace dpl {

/** A stand for each avatar, whose feet are at y = 0. With general splats alone, the floor is below them. The columns stand behind a camera
 *  that is cameraM away from the middle, so that nothing hides the subjects. box: around them, y up. */
platform::RoomPlan roomAround(const std::vector<ViewedSubject>& subjects, const WorldBox& box, double cameraM);

}  // namespace dpl
