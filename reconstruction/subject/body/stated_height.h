// SPDX-License-Identifier: Apache-2.0
// The height that a person states. Private to reconstruction/subject/body.
#pragma once

#include <ceres/cost_function.h>

#include "reconstruction/subject/body/body_model.h"

namespace dpl {

/** Pulls the shape to this height at rest, from the lowest to the highest vertex of the mean body. Where keypoints alone decide, tall and
 *  far is short and near. Block: shape. Null when no morph changes the height. The caller owns the result. */
ceres::CostFunction* makeStatedHeight(const BodyModel& body, double heightM);

}  // namespace dpl
