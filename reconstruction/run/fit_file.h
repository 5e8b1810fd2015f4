// SPDX-License-Identifier: Apache-2.0
// The body fit as a JSON file, for later stages. Reading checks that sizes are right and numbers finite.
#pragma once

#include <filesystem>

#include "reconstruction/subject/body/fit_body.h"
#include "reconstruction/subject/hands/fit_fingers.h"
#include "sdk/core/result.h"

namespace dpl {

/** The fit as JSON. Numbers have enough digits to be read back bit for bit. */
std::string fitToJson(const BodyFit& fit);
Result<BodyFit> readFitFile(const std::filesystem::path& path, size_t frameCount, size_t jointCount, size_t morphCount);

/** What was found of the hands, likewise. */
std::string handsToJson(std::span<const HandFit> hands);
Result<std::vector<HandFit>> readHandsFile(const std::filesystem::path& path);

}  // namespace dpl
