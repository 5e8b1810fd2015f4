// SPDX-License-Identifier: Apache-2.0
// A shake of the procedural subject's head, for hair that swings.
#pragma once

#include <cstdint>

#include "reconstruction/subject/sample/skinning.h"

namespace dpl {

/** The head turns left and right by about 35°, once or twice a second, for about a seventh of the motion. The seed decides when, how fast
 *  and to which side first. */
class HeadShake {
public:
    HeadShake(uint64_t seed, double durationS);
    /** Adds its turn of neck and head to a pose. Twice continuously differentiable in time. */
    void turn(double timeS, TruthPose& pose) const;

private:
    double startS_ = 0, lengthS_ = 0, frequencyHz_ = 0, amplitudeRad_ = 0;
};

}  // namespace dpl
