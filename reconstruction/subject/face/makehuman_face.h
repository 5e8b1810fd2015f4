// SPDX-License-Identifier: Apache-2.0
// Expressions of bodies from MakeHuman data, by its expression units (CC0). Names, units and weights: docs/reference/expressions.md.
#pragma once

#include <filesystem>
#include <vector>

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** All 52 expressions of a body that importMakeHuman made of this folder, or none where the folder has no expression units, or no parts of
 *  the face in its mesh. Each unit is the mean of its three families. Left and right mirror each other exactly on the base mesh. Lids stay
 *  outside the eyeballs at every weight. CorruptData names the file; InvalidArgument: a body of another mesh. */
Result<std::vector<ExpressionShape>> makeHumanExpressions(const std::filesystem::path& folder, const BodyModel& body);

}  // namespace dpl
