// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/playback.h"

#include <cmath>

namespace dpl {

double timeInClip(double timeS, double durationS) {
    if (!(durationS > 0)) return 0;
    const double within = timeS - durationS * std::floor(timeS / durationS);
    return within < durationS ? within : 0;  // rounding may give the end
}

}  // namespace dpl
