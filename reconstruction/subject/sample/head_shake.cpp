// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/head_shake.h"

#include <cmath>

#include "reconstruction/subject/sample/ease.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"

namespace dpl {
namespace {

constexpr uint64_t kShakeStream = 8600;
constexpr double kRadPerDegree = 0.017453292519943295;
constexpr double kEaseShare = 0.2;  // of its length, at each end
constexpr double kNeckShare = 0.4;  // of the turn

}  // namespace

HeadShake::HeadShake(uint64_t seed, double durationS) {
    Random random(seed, kShakeStream);
    // About 9.1 s of 18.75, where samples of every size hold a frame out.
    startS_ = durationS * random.uniform(0.40, 0.42);
    lengthS_ = durationS * random.uniform(0.14, 0.16);
    frequencyHz_ = random.uniform(1.1, 1.9);
    amplitudeRad_ = (random.below(2) ? 1 : -1) * random.uniform(32, 38) * kRadPerDegree;
}

void HeadShake::turn(double timeS, TruthPose& pose) const {
    const double t = timeS - startS_, rise = kEaseShare * lengthS_;
    const double level = ease(t / rise) - ease((t - lengthS_ + rise) / rise);
    const double yaw = amplitudeRad_ * level * std::sin(6.283185307179586 * frequencyHz_ * t);
    pose.rotations[kNeck].y += kNeckShare * yaw;
    pose.rotations[kHead].y += (1 - kNeckShare) * yaw;
}

}  // namespace dpl
