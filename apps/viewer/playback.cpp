// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/playback.h"

#include <algorithm>
#include <cmath>

namespace dpl {

double timeInClip(double timeS, double durationS, bool loop) {
    if (!(durationS > 0)) return 0;
    if (!loop) return std::clamp(timeS, 0.0, durationS);
    const double within = timeS - durationS * std::floor(timeS / durationS);
    return within < durationS ? within : 0;  // rounding may give the end
}

}  // namespace dpl
