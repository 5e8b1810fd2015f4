// SPDX-License-Identifier: Apache-2.0
// Spreads vectors that some vertices of a mesh have to their neighbours.
#pragma once

#include <vector>

#include "reconstruction/subject/shape/large_steps.h"

namespace dpl {

/** Mean over the mesh, weighted by `weights` and by the kernel of `smooth`:
 *  M⁻²(values) / (M⁻²(weights) + epsilon). One entry per vertex; values are already multiplied by their weights. epsilon lets the mean fade
 * to zero far from all weights. */
std::vector<Vec3f> smoothMean(const LargeSteps& smooth, const std::vector<Vec3f>& values, const std::vector<float>& weights, float epsilon);

}  // namespace dpl
