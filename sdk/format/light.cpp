// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/light.h"

#include <cmath>

namespace dpl {

Status checkLight(const LightData& light) {
    for (const float c : light.irradiance)
        if (!(std::abs(c) <= kMostIrradiance))
            return fail(Code::CorruptData, "the light has a coefficient of {}; magnitudes up to {} are possible", c, kMostIrradiance);
    return {};
}

}  // namespace dpl
