// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** What a short look of the pose network tells of a picture: the best person in it. */
struct Glance {
    size_t people = 0;               // confirmed; 0: the rest is empty
    double secondShare = 0;          // height of the second person's box, of the first one's
    std::vector<Vec2d> landmarks;    // 33, BlazePose order, pixels; outside the picture where the network says so
    std::vector<double> confidence;  // 33, 0 … 1: in the picture and not hidden
    double turnRad = 0;              // where the camera stands round the person: 0 before the chest, π/2 at the person's left
};

}  // namespace dpl
