// SPDX-License-Identifier: Apache-2.0
// Parts of an avatar that the camera goes to.
#pragma once

#include <optional>

#include "apps/viewer/subject.h"

namespace dpl {

enum class SeenPart : uint8_t { Whole, Face, LeftHand, RightHand };

/** The box around a part of the subject as it stands now, world, metres. Nothing: no joint is known as that part. The whole is the box at
 *  rest. */
std::optional<WorldBox> boxOfPart(const ViewedSubject& subject, SeenPart part);

/** Where a ray through a pixel first meets an avatar. camera: of the picture that holds the pixel. */
struct PickedPlace {
    size_t subject = 0;
    Vec3d point{0};  // world, metres
};
/** Nothing: no avatar is there. General splats are not met, for they have no mesh; nor is what is hidden. */
std::optional<PickedPlace> placeAt(const std::vector<ViewedSubject>& subjects, const Camerad& camera, const Vec2d& px);

}  // namespace dpl
