// SPDX-License-Identifier: Apache-2.0
// Light of the scene as data: its check (docs/formats/avatar.md).
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr float kMostIrradiance = 4;  // of a coefficient

/** Refuses coefficients that are not finite or above kMostIrradiance (CorruptData). */
Status checkLight(const LightData& light);

}  // namespace dpl
